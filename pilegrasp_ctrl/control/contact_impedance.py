"""Impedance control: stiff in free motion, and yielding along the directions of a desired force."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from ..arm.model import ArmModel
from ..arm.state import ArmState
from ..exceptions import ConfigurationError
from ..limits.limit import Limit
from ..limits.standard import LIMITS
from ..qp.solvers import Solver
from ..tasks.gain_values import check_wrench, read_number
from ..tasks.gains import FORCE_GAIN_MEANING, Impedance
from ..tasks.tool_axes import turn_wrench
from ..types import Array, Command, ControllerOutput, Observation, Reference
from .force_command import ForceFeedback, ForceRamp
from .impedance import ImpedanceController
from .sampled_data import check_force_gain

YIELDING_STIFFNESS = 0.06
"""Share of the stiffness kept along a desired force; chosen: it returns the tool, and adds little to 5 N."""
RAMP_TIME = 0.1
"""Duration of the change from position to force and back [s]; chosen."""
_VERTICAL = (0.0, 0.0, 1.0)
"""Default direction along which the hand yields to a desired force."""
_INDEPENDENT = 1e-9
"""Part of a direction outside the others, over its length, from which on it adds to them; chosen."""


class ContactImpedanceController:
    """Two impedance controllers behind one `step`: for position in all directions, and for force in some of them.

    The caller's desired force decides when to press. If the gains have a desired force, they decide how hard; see
    `create`. During the change both controllers compute torques within the limits, and these are mixed. The limits are
    convex, so the mixture is within them too.

    The controller remembers the progress of the change, and the correction of the force if there is one.

    Attributes:
        free: Controller while no force is desired.
        yielding: Controller while a force is desired.
    """

    def __init__(
        self,
        free: ImpedanceController,
        yielding: ImpedanceController,
        *,
        own_force: Impedance | None = None,
        force_gain: float = 0.0,
        force_ramp: float = RAMP_TIME,
    ) -> None:
        """Join two controllers of the same arm.

        Args:
            free: Controller while no force is desired.
            yielding: Controller while a force is desired.
            own_force: Gains whose desired force replaces the caller's; None keeps the caller's.
            force_gain: Rate at which the measured wrench corrects the force [1/s]; 0 turns the correction off.
            force_ramp: Duration of the change from one controller to the other [s].

        Raises:
            ConfigurationError: The gain or the time is negative or not finite.
        """
        self.free, self.yielding = free, yielding
        self._own_force = own_force
        self._ramp = ForceRamp(read_number(force_ramp, "force_ramp", "it is a time in s, and 0 switches at once"))
        gain = read_number(force_gain, "force_gain", FORCE_GAIN_MEANING)
        self._feedback = ForceFeedback(gain) if gain > 0.0 else None

    @classmethod
    def create(
        cls,
        arm: ArmModel,
        impedance: Impedance,
        posture: Array,
        solver: str | Solver = "daqp",
        rate: float = 500.0,
        force_directions: ArrayLike = _VERTICAL,
        *,
        free: Impedance | None = None,
        wrench_lag: float | None = None,
        force_ramp: float = RAMP_TIME,
        limits: Collection[str | Limit] = LIMITS,
    ) -> ContactImpedanceController:
        """Set up both controllers.

        Gains without a desired force serve all motion. While a force is desired, they keep a small share of their
        stiffness along `force_directions`, and all of their damping. Gains with a desired force serve while a force is
        desired: they act unchanged, and their force replaces the caller's.

        Args:
            arm: Arm to control.
            impedance: Gains [N/m, N·m/rad].
            posture: (nv,) Preferred posture [rad].
            solver: Name of the solver, or an object that solves.
            rate: Rate at which you call `step` [Hz].
            force_directions: Directions that yield, (3,) or (k, 3), of any length, in the axes of the gains.
            free: Gains while no force is desired; required if `impedance` has a desired force.
            wrench_lag: Lag of the measured wrench as for `ImpedanceController` [s].
            force_ramp: Duration of the change from one controller to the other [s].
            limits: Limits of both controllers, as for `ImpedanceController`.

        Raises:
            ConfigurationError: A direction is zero or not finite, `free` is missing or not allowed, or a controller
                cannot be set up.
        """
        own = impedance if impedance.desired_force.any() else None
        if own is not None and free is None:
            raise ConfigurationError(
                "gains with a desired_force act only while a force is desired; give free gains too"
            )
        if own is None and free is not None:
            raise ConfigurationError("free gains are used only beside gains with a desired_force; leave them out")
        basis = _orthonormal_basis(
            impedance.desired_force[:3] if impedance.desired_force[:3].any() else force_directions
        )
        if impedance.force_gain > 0.0:
            check_force_gain(arm, impedance, posture, basis, 0.0 if wrench_lag is None else wrench_lag)
        moving = replace(impedance if free is None else free, force_gain=0.0, desired_force=np.zeros(6))
        stiffness = None if own else _weaken_springs(impedance.stiffness, basis)
        make = partial(
            ImpedanceController,
            arm,
            posture=posture,
            limits=limits,
            solver=solver,
            rate=rate,
            wrench_lag=wrench_lag,
        )
        return cls(
            make(impedance=moving),
            make(impedance=replace(impedance, force_gain=0.0), stiffness=stiffness),
            own_force=own,
            force_gain=impedance.force_gain,
            force_ramp=force_ramp,
        )

    def __repr__(self) -> str:
        return f"ContactImpedanceController({self.free!r}, {self.yielding!r})"

    def step(
        self, observation: Observation, reference: Reference, state: ArmState, desired_force: Array
    ) -> ControllerOutput:
        """Return the torques for one control period.

        Args:
            observation: Measurement of the arm, with the wrench as in `ImpedanceController.step`.
            reference: Rest pose of the springs and its motion.
            state: `arm.update(observation.q, observation.v)`.
            desired_force: (6,) Wrench to exert on the environment, in world axes [N, N·m]; zeros for motion alone.

        Raises:
            ModelError: The observation has a value that is not finite.
            ConfigurationError: The desired force is not six finite numbers.
        """
        desired_force = check_wrench(desired_force, "desired_force")
        if self._own_force is not None and desired_force.any():
            desired_force = self._own_force.desired_force
            if self._own_force.frame == "tool":
                desired_force = turn_wrench(reference.pose.rotation.T, desired_force)
        force = self._ramp.update(observation.time, desired_force)
        share = self._ramp.share
        if self._feedback is not None:
            force = self._feedback.update(observation.time, force, observation.wrench)
        if share == 0.0:
            self.yielding.reset()
            return self.free.step(observation, reference, state=state)
        if share == 1.0:
            self.free.reset()
            return self.yielding.step(observation, reference, state=state, desired_force=force)
        pressing = self.yielding.step(observation, reference, state=state, desired_force=force / share)
        output = _mix(self.free.step(observation, reference, state=state), pressing, share)
        for controller in (self.free, self.yielding):
            controller.remember(observation.time, output.command.torque)
        return output

    @property
    def arm(self) -> ArmModel:
        """Arm to control."""
        return self.free.arm

    def reset(self) -> None:
        """Forget the last period, the ramp of the force and its correction, as before a new motion."""
        self.free.reset()
        self.yielding.reset()
        self._ramp = ForceRamp(self._ramp.duration)
        self._feedback = None if self._feedback is None else ForceFeedback(self._feedback.gain)

    def set_payload(self, mass: float, center_of_mass: ArrayLike, inertia: ArrayLike | None = None) -> None:
        """Replace the payload that the hand carries from now on; see `InverseDynamics.set_payload`."""
        self.free.set_payload(mass, center_of_mass, inertia)
        self.yielding.set_payload(mass, center_of_mass, inertia)


def _orthonormal_basis(directions: ArrayLike) -> Array:
    """Return (k, 3) orthonormal directions that span the given ones (3,) or (n, 3)."""
    given = np.atleast_2d(np.asarray(directions, dtype=np.float64))
    if given.ndim != 2 or given.shape[1] != 3 or not np.isfinite(given).all():
        raise ConfigurationError(f"force_directions = {given.tolist()} must be directions of three finite numbers")
    basis: list[Array] = []
    for direction in given:
        size, rest = np.sqrt((direction * direction).sum()), direction
        for _ in range(2):  # the second pass removes the round-off of the first
            for one in basis:
                rest = rest - (one * rest).sum() * one
        left = np.sqrt((rest * rest).sum())
        if left > _INDEPENDENT * max(size, _INDEPENDENT):
            basis.append(rest / left)
    if not basis:
        raise ConfigurationError("force_directions are all zero; give a direction, such as (0, 0, 1) for the vertical")
    return np.array(basis)


def _weaken_springs(stiffness: Array, basis: Array) -> Array:
    """Return (6, 6) the stiffness with its springs weakened along `basis` (k, 3).

    It is K^½ (1 - (1 - share) P) K^½ with the projector P. It is symmetric; along an axis it is just a smaller number.
    """
    weaken = np.eye(6)
    weaken[:3, :3] -= (1.0 - YIELDING_STIFFNESS) * (basis[:, :, None] * basis[:, None, :]).sum(axis=0)
    root = np.sqrt(stiffness)
    return root[:, None] * weaken * root


def _mix(free: ControllerOutput, pressing: ControllerOutput, share: float) -> ControllerOutput:
    """Return the mixture of two outputs; a limit binds it only if it binds both."""
    torque = (1.0 - share) * free.command.torque + share * pressing.command.torque
    acceleration = (1.0 - share) * free.acceleration + share * pressing.acceleration
    active = tuple(name for name in free.active_limits if name in pressing.active_limits)
    solve_time = free.solve_time + pressing.solve_time
    fallback, refused = free.fallback or pressing.fallback, free.refused or pressing.refused
    return ControllerOutput(Command(torque), acceleration, active, solve_time, fallback, refused)
