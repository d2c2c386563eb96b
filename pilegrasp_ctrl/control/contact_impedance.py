"""Impedance control that is stiff in free motion and yields along the directions on which a force is asked for."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from ..arm.model import ArmModel
from ..arm.state import ArmState
from ..exceptions import ConfigurationError
from ..tasks.gain_values import checked_wrench, scalar
from ..tasks.gains import Impedance
from ..types import Array, Command, ControllerOutput, Observation, Reference
from .force_command import ForceFeedback, ForceRamp
from .impedance import ImpedanceController
from .sampled_data import check_force_gain
from .tool_axes import turn_wrench

YIELDING_STIFFNESS = 0.06
"""Share of the stiffness that a direction with a desired force keeps: enough to come back, but little beside 5 N."""
HAND_OVER = 0.1
"""From position to force and back [s]."""
UP = (0.0, 0.0, 1.0)


class ContactImpedanceController:
    """Two impedance controllers behind one `step`: position in every direction, or force in some of them.

    The caller's desired force says when to press; gains with a desired force of their own say how hard (see `create`).
    During the hand-over both controllers compute torques within the limits, and these are mixed; the limits are convex,
    so the mixture is within them too.

    Remembers how far the hand-over has got, and the correction of the force where there is one.

    Attributes:
        free: used while no force is asked for.
        yielding: used while a force is asked for.
    """

    def __init__(
        self,
        free: ImpedanceController,
        yielding: ImpedanceController,
        *,
        own_force: Impedance | None = None,
        force_gain: float = 0.0,
        force_ramp: float = HAND_OVER,
    ) -> None:
        """Join two controllers of the same arm.

        Args:
            free: used while no force is asked for.
            yielding: used while a force is asked for.
            own_force: gains whose desired force stands in place of the one that is asked for.
            force_gain: of the force's correction by the measured wrench [1/s]; 0 is none.
            force_ramp: how long it takes from one to the other [s].

        Raises:
            ConfigurationError: where the gain or the time is negative or not finite.
        """
        self.free, self.yielding = free, yielding
        self._own = own_force
        self._hand_over = ForceRamp(scalar(force_ramp, "force_ramp", "it is a time in s, and 0 switches at once"))
        gain = scalar(force_gain, "force_gain", "it is a rate in 1/s, and 0 turns the feedback off")
        self._feedback = ForceFeedback(gain) if gain > 0.0 else None

    @classmethod
    def create(
        cls,
        arm: ArmModel,
        impedance: Impedance,
        posture: Array,
        solver: str = "daqp",
        rate: float = 500.0,
        force_directions: ArrayLike = UP,
        *,
        free: Impedance | None = None,
        wrench_lag: float | None = None,
        force_ramp: float = HAND_OVER,
    ) -> ContactImpedanceController:
        """Set up both controllers.

        Gains without a desired force are for all motion. While a force is asked for, a small share of their stiffness
        is left along `force_directions`, and all of their damping. Gains with a desired force are for the time in which
        a force is asked for: they act as they are, and their force counts instead of the one that is asked for.

        Args:
            arm: the arm.
            impedance: the gains.
            posture: (nv,) preferred [rad].
            solver: "daqp" or "osqp".
            rate: how often `step` is called [Hz].
            force_directions: (3,) or (k, 3) that yield, along the axes of the gains, of any length.
            free: gains for the time without a force, beside gains with a desired force.
            wrench_lag: as for `ImpedanceController`.
            force_ramp: from one to the other [s].

        Raises:
            ConfigurationError: where a direction is no direction, `free` is missing or has no place, or a controller
                cannot be set up.
        """
        own = impedance if impedance.desired_force.any() else None
        if own is not None and free is None:
            raise ConfigurationError("desired_force acts while a force is asked for; give free gains for the rest")
        if own is None and free is not None:
            raise ConfigurationError("free gains have a place only beside gains with a desired_force")
        basis = _basis(impedance.desired_force[:3] if impedance.desired_force[:3].any() else force_directions)
        if impedance.force_gain > 0.0:
            check_force_gain(arm, impedance, posture, basis, 0.0 if wrench_lag is None else wrench_lag)
        moving = replace(impedance if free is None else free, force_gain=0.0, desired_force=np.zeros(6))
        stiffness = None if own else _yielding(impedance.stiffness, basis)
        make = partial(ImpedanceController, arm, posture=posture, solver=solver, rate=rate, wrench_lag=wrench_lag)
        return cls(
            make(impedance=moving),
            make(impedance=replace(impedance, force_gain=0.0), stiffness=stiffness),
            own_force=own,
            force_gain=impedance.force_gain,
            force_ramp=force_ramp,
        )

    def step(
        self, observation: Observation, reference: Reference, state: ArmState, desired_force: Array
    ) -> ControllerOutput:
        """Return the torques for one control period; the wrench of the observation as in `ImpedanceController.step`.

        Args:
            observation: what the arm measures.
            reference: where the springs rest.
            state: `arm.update(observation.q, observation.v)`.
            desired_force: (6,) to exert on the environment, zeros for motion alone, world axes [N, N·m].

        Raises:
            ModelError: where the observation holds a value that is not finite.
            ConfigurationError: where the desired force is not six finite numbers.
        """
        desired_force = checked_wrench(desired_force, "desired_force")
        if self._own is not None and desired_force.any():
            desired_force = self._own.desired_force
            if self._own.frame == "tool":
                desired_force = turn_wrench(reference.pose.rotation.T, desired_force)
        force = self._hand_over.update(observation.time, desired_force)
        share = self._hand_over.share
        if self._feedback is not None:
            force = self._feedback.update(observation.time, force, observation.wrench)
        if share == 0.0:
            return self.free.step(observation, reference, state=state)
        if share == 1.0:
            return self.yielding.step(observation, reference, state=state, desired_force=force)
        pressing = self.yielding.step(observation, reference, state=state, desired_force=force / share)
        return _mixed(self.free.step(observation, reference, state=state), pressing, share)


def _basis(directions: ArrayLike) -> Array:
    """Return (k, 3) orthonormal directions that span the same as the given ones (3,) or (n, 3)."""
    given = np.atleast_2d(np.asarray(directions, dtype=np.float64))
    if given.ndim != 2 or given.shape[1] != 3 or not np.isfinite(given).all():
        raise ConfigurationError(f"force_directions = {given.tolist()} must be directions of three finite numbers")
    sizes, basis = np.linalg.svd(given, full_matrices=False)[1:]
    basis = basis[sizes > 1e-9 * max(sizes[0], 1e-9)]
    if not len(basis):
        raise ConfigurationError("force_directions are all zero; (0, 0, 1) yields along the vertical")
    return basis


def _yielding(stiffness: Array, basis: Array) -> Array:
    """Return (6, 6) the stiffness that is left when its springs are weakened along `basis` (k, 3).

    K^½ (1 - (1 - share) P) K^½ with the projector P: symmetric, and along an axis just a smaller number.
    """
    weaken = np.eye(6)
    weaken[:3, :3] -= (1.0 - YIELDING_STIFFNESS) * basis.T @ basis
    root = np.sqrt(stiffness)
    return root[:, None] * weaken * root


def _mixed(free: ControllerOutput, pressing: ControllerOutput, share: float) -> ControllerOutput:
    """Return the mixture; a limit binds it only where it binds both."""
    torque = (1.0 - share) * free.command.torque + share * pressing.command.torque
    acceleration = (1.0 - share) * free.acceleration + share * pressing.acceleration
    active = tuple(name for name in free.active_limits if name in pressing.active_limits)
    solve_time = free.solve_time + pressing.solve_time
    return ControllerOutput(Command(torque), acceleration, active, solve_time, free.fallback or pressing.fallback)
