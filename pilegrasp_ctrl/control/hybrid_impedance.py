"""Impedance control that is stiff in free motion and yields along the axes on which a force is asked for."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arm_model import ArmModel
from ..arm_state import ArmState
from ..types import Array, ControllerOutput, Observation, Reference
from .gains import Impedance
from .impedance import ImpedanceController

YIELDING_STIFFNESS = 0.06
"""Share of the stiffness that an axis with a desired force keeps: enough to come back, too little to disturb 5 N."""


@dataclass(frozen=True)
class HybridImpedanceController:
    """Two impedance controllers behind one `step`: position on every axis, or force on some and position on the rest.

    Attributes:
        free: used while no force is asked for.
        yielding: used while any force is asked for; along `force_axes` it keeps little stiffness.
    """

    free: ImpedanceController
    yielding: ImpedanceController

    @classmethod
    def create(
        cls,
        arm: ArmModel,
        impedance: Impedance,
        posture: Array,
        solver: str,
        rate: float,
        force_axes: tuple[int, ...] = (2,),
    ) -> HybridImpedanceController:
        """Set up both controllers; along `force_axes` (world axes, 2 is up) the second keeps little stiffness."""
        stiffness = impedance.stiffness.copy()
        stiffness[list(force_axes)] *= YIELDING_STIFFNESS
        soft = replace(impedance, stiffness=stiffness)
        return cls(
            ImpedanceController(arm, impedance, posture, solver=solver, rate=rate),
            ImpedanceController(arm, soft, posture, solver=solver, rate=rate),
        )

    def step(
        self, observation: Observation, reference: Reference, state: ArmState, desired_force: Array
    ) -> ControllerOutput:
        """Return the torques for one control period; `desired_force` (6,) [N, N·m] acts on the environment."""
        controller = self.yielding if np.any(desired_force) else self.free
        return controller.step(observation, reference, state=state, desired_force=desired_force)
