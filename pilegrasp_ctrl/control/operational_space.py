"""Operational-space motion control: the tool follows its reference as a unit mass would."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import ArrayLike

from ..arm.model import ArmModel
from ..arm.state import ArmState
from ..exceptions import ConfigurationError
from ..tasks.frame_task import FrameMotionTask, pose_error
from ..tasks.gains import MotionGains
from ..tasks.posture_task import PostureTask
from ..types import Array, ControllerOutput, Observation, Reference
from .compiled_motion import CompiledMotion
from .friction_compensation import FrictionCompensation, make_compensation
from .inverse_dynamics import LIMITS, InverseDynamics

DEFAULT_GAINS = MotionGains(stiffness=[900.0, 900.0, 900.0, 1600.0, 1600.0, 1600.0])
"""Default gains of the tool's motion [1/s²], critically damped; chosen."""


class OperationalSpaceController:
    """Torques that make the tool follow position, velocity and acceleration of a reference, within all limits.

    After Khatib, "A unified approach for motion and force control of robot manipulators: the operational space
    formulation", IEEE J. Robotics and Automation 3(1), 1987. If no limit is active, and as the posture's weight goes to
    zero, the tool accelerates as under Khatib's closed form.

    `step` is a pure function of observation and reference; nothing is remembered between steps.
    """

    def __init__(
        self,
        arm: ArmModel,
        gains: MotionGains = DEFAULT_GAINS,
        posture: PostureTask | ArrayLike | None = None,
        *,
        weight: ArrayLike = 1.0,
        mask: ArrayLike | None = None,
        limits: Collection[str] = LIMITS,
        friction: FrictionCompensation | bool = True,
        solver: str = "daqp",
        rate: float = 500.0,
        compiled: bool = False,
    ) -> None:
        """Set up the controller.

        Args:
            arm: Arm to control.
            gains: Gains of the tool's motion [1/s²].
            posture: (nv,) Preferred joint positions [rad], or a posture task; by default the freedom that the tool
                leaves is only damped.
            weight: Scalar or (6,) weights of the tool's axes against each other.
            mask: (6,) Booleans; False leaves an axis free.
            limits: Limits to enforce, of "torque", "velocity" and "position".
            friction: Whether to feed the arm's joint friction forward, or the feed-forward itself.
            solver: Name of the solver: "daqp", "osqp", "proxqp" or "quadprog".
            rate: Rate at which you call `step` [Hz]; velocity and position limits look ahead by two periods.
            compiled: Whether to run the usual period in compiled code, which needs numba; see `CompiledMotion`.

        Raises:
            GainsError: The gains are not `MotionGains`.
            ArgumentError: A weight or the posture is not usable.
            ConfigurationError: Another argument is not usable.
        """
        self.arm = arm
        posture = posture if isinstance(posture, PostureTask) else PostureTask(posture)
        self._task = FrameMotionTask(gains, weight, mask, posture_weight=posture.weight)
        self._dynamics = InverseDynamics(arm, self._task, posture, limits, solver, rate)
        self._friction = make_compensation(arm, friction)
        self._compiled = CompiledMotion(self._dynamics, self._task, self._friction) if compiled else None

    def __repr__(self) -> str:
        return f"OperationalSpaceController({self.arm!r}, {self._task!r}, solver={self._dynamics.solver.name!r})"

    def step(
        self,
        observation: Observation,
        reference: Reference,
        posture: Array | None = None,
        state: ArmState | None = None,
        disturbance: Array | None = None,
    ) -> ControllerOutput:
        """Return the torques for one control period.

        Args:
            observation: Measurement of the arm.
            reference: Reference of the tool.
            posture: (nv,) Preferred posture for this period [rad].
            state: `arm.update(observation.q, observation.v)`, if you have it already.
            disturbance: (nv,) Torque of the environment on the joints [N·m], as `DisturbanceObserver` estimates it. It
                is cancelled within the torque limits. Do not give it in contact, because it would work against the
                touched object.

        Raises:
            ModelError: The observation has a wrong shape or a value that is not finite.
            ConfigurationError: The posture or the disturbance has a wrong shape or a value that is not finite.
        """
        state = self.arm.update(observation.q, observation.v) if state is None else state
        if self._compiled is not None and posture is None and disturbance is None:
            output = self._compiled.step(state, reference)
            if output is not None:
                return output
        error = pose_error(state, reference)
        dynamics = self._dynamics
        dynamics.assemble(state, self._task.acceleration(state, reference, error), posture)
        feedforward = None if self._friction is None else self._friction.torque(dynamics, reference, error)
        cancelled = None
        if disturbance is not None:
            if np.shape(disturbance) != state.q.shape or not np.isfinite(disturbance).all():
                raise ConfigurationError(f"the disturbance must be {self.arm.nv} finite numbers; it is {disturbance}")
            cancelled = np.negative(disturbance)
        return dynamics.solve(state, feedforward, cancelled)
