"""Impedance control: the hand yields to contact as the springs, dampers and forces that were asked for."""

from __future__ import annotations

from collections.abc import Collection
from math import isfinite

import numpy as np
from numpy.typing import ArrayLike

from ..arm_model import ArmModel
from ..arm_state import ArmState
from ..exceptions import ConfigurationError, ModelError, PilegraspError
from ..tasks.frame_task import pose_error
from ..tasks.impedance_task import ImpedanceTask
from ..tasks.posture_task import PostureTask
from ..types import Array, ControllerOutput, Observation, Reference
from .friction import FrictionCompensation
from .gains import Impedance
from .inverse_dynamics import LIMITS, InverseDynamics


class ImpedanceController:
    """Torques that make the tool yield as an `Impedance`, within all limits.

    After Hogan, "Impedance control: an approach to manipulation", J. Dynamic Systems, Measurement, and Control 107,
    1985; `ImpedanceTask` states the law. Steady contact gives the force K e + desired force, up to joint friction.

    A pure function of observation and reference: nothing is remembered between steps.
    """

    def __init__(
        self,
        arm: ArmModel,
        impedance: Impedance,
        posture: PostureTask | ArrayLike | None = None,
        *,
        weight: ArrayLike = 1.0,
        mask: ArrayLike | None = None,
        limits: Collection[str] = LIMITS,
        friction: FrictionCompensation | bool = True,
        solver: str = "daqp",
        rate: float = 500.0,
    ) -> None:
        """Set up the controller; arguments as for `OperationalSpaceController`, but for the impedance in N/m.

        The friction feed-forward follows the reference's motion only: acting on the error it would add to the force
        of a steady contact.

        Raises:
            TypeError: where the impedance is not an `Impedance`.
            ConfigurationError: where another argument cannot be used.
        """
        self.arm = arm
        self._task = ImpedanceTask(impedance, weight, mask)
        posture = posture if isinstance(posture, PostureTask) else PostureTask(posture)
        self._dynamics = InverseDynamics(arm, self._task, posture, limits, solver, rate)
        if isinstance(friction, bool):
            self._friction = FrictionCompensation(arm, error_rate=0.0) if friction else None
        else:
            self._friction = friction

    def step(
        self,
        observation: Observation,
        reference: Reference,
        posture: Array | None = None,
        state: ArmState | None = None,
        desired_force: Array | None = None,
    ) -> ControllerOutput:
        """Return the torques for one control period.

        Args:
            observation: what the arm measures; its wrench, moved to the tool's origin by the caller, matters only where
                the impedance has an inertia.
            reference: where the springs rest.
            posture: (nv,) in place of the preferred posture, for this period [rad].
            state: `arm.update(observation.q, observation.v)` where the caller has it already.
            desired_force: (6,) in place of the impedance's own, for this period [N, N·m].

        Raises:
            ModelError: where the observation has a wrong shape or holds a value that is not finite.
            ConfigurationError: where the posture or the desired force has or does.
        """
        state = self.arm.update(observation.q, observation.v) if state is None else state
        gains = self._task.impedance
        force = (
            gains.desired_force if desired_force is None else _six(desired_force, "desired_force", ConfigurationError)
        )
        shaped = gains.inertia is not None
        wrench = observation.wrench
        if shaped:
            wrench = _dead_band(_six(wrench, "the observed wrench", ModelError), gains.dead_band)
        error = pose_error(state, reference)
        dynamics = self._dynamics
        dynamics.assemble(state, self._task.acceleration(state, reference, error, force, wrench), posture)
        feedforward = None if self._friction is None else self._friction.torque(dynamics, reference, error)
        if shaped:
            cancelled = -state.J.T.dot(wrench)
            feedforward = cancelled if feedforward is None else feedforward + cancelled
        return dynamics.solve(state, feedforward)


def _six(value: ArrayLike, name: str, error: type[PilegraspError]) -> Array:
    array = np.asarray(value, dtype=np.float64)
    if array.shape != (6,) or not isfinite(array.dot(array)):
        raise error(f"{name} must be six finite numbers, force first; it is {array.tolist()}")
    return array


def _dead_band(wrench: Array, band: tuple[float, float]) -> Array:
    """Shorten force and torque by their dead bands, so that neither jumps where it leaves its band."""
    out = np.zeros(6)
    for part, width in zip((slice(0, 3), slice(3, 6)), band, strict=True):
        size = float(np.sqrt(wrench[part].dot(wrench[part])))
        if size > width:
            out[part] = wrench[part] * (1.0 - width / size)
    return out
