"""Operational-space motion control: the tool follows its reference as a unit mass would."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from numpy.typing import ArrayLike

from ..arm.model import ArmModel
from ..arm.state import ArmState
from ..limits.limit import Limit
from ..limits.standard import LIMITS
from ..qp.solvers import Solver
from ..tasks.frame_task import DEFAULT_GAINS, FrameTask
from ..tasks.gains import MotionGains
from ..tasks.posture_task import PostureTask
from ..tasks.task import Task
from ..types import Array, ControllerOutput, Observation, Pose, Reference
from .friction_compensation import FrictionCompensation
from .inverse_dynamics import InverseDynamics


class OperationalSpaceController(InverseDynamics):
    """Torques that make the tool follow position, velocity and acceleration of a reference, within all limits.

    It is `InverseDynamics` with a `FrameTask` for the tool and a `PostureTask`. After Khatib, "A unified approach for
    motion and force control of robot manipulators: the operational space formulation", IEEE J. Robotics and Automation
    3(1), 1987. If no limit is active, and as the posture's weight goes to zero, the tool accelerates as under Khatib's
    closed form.

    The torque depends on observation and reference alone, unless a `TorqueRateLimit` is among the limits.

    Attributes:
        tool: Task of the tool.
        posture: Task of the posture.
    """

    def __init__(
        self,
        arm: ArmModel,
        gains: MotionGains = DEFAULT_GAINS,
        posture: PostureTask | ArrayLike | None = None,
        *,
        weight: ArrayLike = 1.0,
        mask: ArrayLike | None = None,
        tasks: Sequence[Task] = (),
        limits: Collection[str | Limit] = LIMITS,
        friction: FrictionCompensation | bool = True,
        solver: str | Solver = "daqp",
        rate: float = 500.0,
        compiled: bool = False,
    ) -> None:
        """Set up the controller.

        Args:
            arm: Arm to control.
            gains: Gains of the tool's motion [1/s²].
            posture: (nv,) Preferred joint positions [rad], or a posture task; by default the freedom that the tool
                leaves is only damped, and the joints of a redundant arm drift.
            weight: Scalar or (6,) weights of the tool's axes against each other.
            mask: (6,) Booleans; False leaves an axis free.
            tasks: Tasks besides those of tool and posture.
            limits: Limits, objects or names out of "torque", "velocity" and "position".
            friction: Whether to feed the arm's joint friction forward, or the feed-forward itself.
            solver: Name of the solver, or an object that solves.
            rate: Rate at which you call `step` [Hz]; velocity and position limits look ahead by two periods.
            compiled: Without effect; the law is always compiled.

        Raises:
            GainsError: The gains are not `MotionGains`.
            ArgumentError: A weight or the posture is not usable.
            ConfigurationError: Another argument is not usable.
        """
        self.posture = posture if isinstance(posture, PostureTask) else PostureTask(arm, posture)
        self.tool = FrameTask(arm, None, gains, weight=weight, mask=mask, posture_weight=self.posture.weight)
        super().__init__(arm, [self.tool, self.posture, *tasks], limits, solver, rate, friction=friction)

    def __repr__(self) -> str:
        return f"OperationalSpaceController({self.arm!r}, {self.tool!r}, solver={self.solver_name!r})"

    def step(  # type: ignore[override]
        self,
        observation: Observation,
        reference: Reference | Pose,
        posture: Array | None = None,
        state: ArmState | None = None,
        disturbance: Array | None = None,
    ) -> ControllerOutput:
        """Return the torques for one control period.

        Args:
            observation: Measurement of the arm.
            reference: Reference of the tool, or a pose to rest at.
            posture: (nv,) Preferred posture for this period [rad].
            state: `arm.update(observation.q, observation.v)`, if you have it already.
            disturbance: As in `InverseDynamics.step`.

        Raises:
            ModelError: The observation has a wrong shape or a value that is not finite.
            ArgumentError: The reference is neither a reference nor a pose.
            ConfigurationError: The posture or the disturbance has a wrong shape or a value that is not finite.
        """
        self.tool.set_target(reference)
        if posture is None:
            return super().step(observation, state, disturbance)
        with self.posture.instead(posture):
            return super().step(observation, state, disturbance)
