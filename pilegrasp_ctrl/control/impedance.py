"""Impedance control: the tool yields to contact like the springs and dampers of its gains."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from numpy.typing import ArrayLike

from ..arm.model import ArmModel
from ..arm.state import ArmState
from ..exceptions import ConfigurationError
from ..limits.limit import Limit
from ..limits.standard import LIMITS
from ..qp.solvers import Solver
from ..tasks.gains import Impedance
from ..tasks.impedance_task import ImpedanceTask
from ..tasks.posture_task import PostureTask
from ..tasks.task import Task
from ..types import Array, ControllerOutput, Observation, Pose, Reference
from .friction_compensation import FrictionCompensation, make_compensation
from .inertia_weighted_dynamics import InertiaWeightedDynamics
from .sampled_data import check_stability


class ImpedanceController(InertiaWeightedDynamics):
    """Torques that make the tool yield as an `Impedance`, within all limits.

    It is `InertiaWeightedDynamics` with an `ImpedanceTask` for the tool and a `PostureTask`. After Hogan, "Impedance
    control: an approach to manipulation", J. Dynamic Systems, Measurement, and Control 107, 1985. Steady contact gives
    the force K e + desired force, up to joint friction. `docs/impedance.md` has the details.

    Away from the limits, the torque depends on observation and reference alone. If a limit binds, the torque of the
    environment in the last period counts too.

    Attributes:
        tool: Task of the tool.
        posture: Task of the posture.
    """

    def __init__(
        self,
        arm: ArmModel,
        impedance: Impedance,
        posture: PostureTask | ArrayLike | None = None,
        *,
        weight: ArrayLike = 1.0,
        mask: ArrayLike | None = None,
        tasks: Sequence[Task] = (),
        limits: Collection[str | Limit] = LIMITS,
        friction: FrictionCompensation | bool = True,
        solver: str | Solver = "daqp",
        rate: float = 500.0,
        stiffness: ArrayLike | None = None,
        wrench_lag: float | None = None,
    ) -> None:
        """Set up the controller.

        Weight and mask are along the axes of the impedance's frame. The friction feed-forward follows the reference's
        motion only: acting on the error, it would add to the force of a steady contact.

        Args:
            arm: Arm to control.
            impedance: Gains [N/m, N·m/rad].
            posture: (nv,) Preferred joint positions [rad], or a posture task. If it is given and
                every tool axis is controlled, the gains are checked there.
            weight: Scalar or (6,) weights of the tool's axes against each other.
            mask: (6,) Booleans; False leaves an axis free.
            tasks: Tasks besides those of tool and posture.
            limits: Limits, objects or names out of "torque", "velocity" and "position".
            friction: Whether to feed the arm's joint friction forward, or the feed-forward itself.
            solver: Name of the solver, or an object that solves.
            rate: Rate at which you call `step` [Hz].
            stiffness: (6, 6) Stiffness in place of the impedance's springs, whose damping stays; symmetric and positive
                semi-definite, in the axes of the gains.
            wrench_lag: Delay of the measured wrench as a first-order lag [s]; with it, an inertia that is too small for
                this lag is refused.

        Raises:
            GainsError: The impedance is not an `Impedance`.
            ArgumentError: A weight or the posture is not usable.
            ConfigurationError: Another argument is not usable, or the sampled loop would not be stable; see
                `sampled_data`.
        """
        self.tool = ImpedanceTask(arm, impedance, weight=weight, mask=mask, stiffness=stiffness)
        if impedance.force_gain > 0.0:
            raise ConfigurationError(
                "force_gain needs a memory: use ContactImpedanceController, or leave force_gain out"
            )
        self.posture = posture if isinstance(posture, PostureTask) else PostureTask(arm, posture)
        compensation = make_compensation(arm, friction, error_rate=0.0)
        super().__init__(arm, [self.tool, self.posture, *tasks], limits, solver, rate, friction=compensation or False)
        if self.posture.stiffness.any() and (self.tool.root == 1.0).all():
            check_stability(arm, impedance, self.posture.target, rate, wrench_lag)

    def __repr__(self) -> str:
        return f"ImpedanceController({self.arm!r}, {self.tool!r}, solver={self.solver_name!r})"

    def step(  # type: ignore[override]
        self,
        observation: Observation,
        reference: Reference | Pose,
        posture: Array | None = None,
        state: ArmState | None = None,
        desired_force: Array | None = None,
    ) -> ControllerOutput:
        """Return the torques for one control period.

        Args:
            observation: Measurement of the arm. Move its wrench to the tool's origin (`move_wrench`); it is used only
                if the impedance has an inertia.
            reference: Rest pose of the springs and its motion, or a pose to rest at.
            posture: (nv,) Preferred posture for this period [rad].
            state: `arm.update(observation.q, observation.v)`, if you have it already.
            desired_force: (6,) Desired force for this period, in world axes [N, N·m]; the impedance's own by default.

        Raises:
            ModelError: The observation has a wrong shape or a value that is not finite.
            ArgumentError: The reference is neither a reference nor a pose.
            ConfigurationError: The posture or the desired force has a wrong shape or a value that is not finite.
        """
        self.tool.set_target(reference, desired_force)
        if posture is None:
            return super().step(observation, state)
        with self.posture.instead(posture):
            return super().step(observation, state)
