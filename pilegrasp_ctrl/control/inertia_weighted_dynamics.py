"""Inverse dynamics for a hand in contact: joints count by their inertia, and limits allow for contact forces."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from math import sqrt
from typing import NamedTuple

import numpy as np

from ..arm.model import ArmModel
from ..arm.state import ArmState
from ..exceptions import ConfigurationError
from ..kernels.algebra import cholesky, mobility, multiply, solve_factored, solve_factored_columns
from ..kernels.friction import coulomb_torque
from ..kernels.program import smallest_margin, weighted_metric
from ..limits.limit import Limit
from ..qp.program import QuadraticProgram
from ..qp.solvers import Solver
from ..tasks.posture_task import DampingTask, PostureTask
from ..tasks.task import Objective, Task
from ..types import Array, ControllerOutput, Observation
from .assembly import Assembly
from .elapsed import MAX_ELAPSED, MIN_ELAPSED
from .friction_compensation import FrictionCompensation
from .inverse_dynamics import (
    EXPECTED_FRICTION_SCALE,
    FRICTION_RESERVE,
    InverseDynamics,
)

TOOL_PRIORITY = 100.0
"""Cost of the tasks' part of a deviation, over that of the freedom that they leave; chosen.

With it the other joints compensate an elbow at its limit. They do not compensate a saturated wrist, whose inertia is a
thousandth of a shoulder's.
"""


class _Period(NamedTuple):
    """Time, state and command of the last period."""

    time: float
    state: ArmState
    acceleration: Array
    friction: Array | None


class InertiaWeightedDynamics(InverseDynamics):
    """The tasks and limits of `InverseDynamics` under a cost that measures joints by their inertia.

        minimise    (a - a*)ᵀ (M + c Aᵀ L A) (a - a*),      a* = a_posture + M⁻¹ Aᵀ F,
                    F = L (b - A a_posture),                L = (A M⁻¹ Aᵀ + w)⁻¹

    A a = b are the rows of all tasks but the posture's, whose weight is w. a* minimises the cost of `InverseDynamics`
    with the posture's part measured by the inertia. As w goes to zero, its torque is Khatib's dynamically consistent
    `Jᵀ F + M a_posture + h` (IEEE J-RA 3(1), 1987). A spring then acts as `Jᵀ` force: a push at the tool and the
    springs' answer cancel in every joint, not only at the tool. Equal weights for all joints would answer a push that
    turns a light wrist with the heavy joints of the shoulder. Added to the mobility A M⁻¹ Aᵀ, w is the mobility of a
    mass of 1 / w = 10 t. It changes a force by less than a thousandth, and it keeps the acceleration finite at a
    singular posture.

    If no limit is active, a* is the answer. With an active limit, the metric M alone would be Gauss's principle of
    least constraint. The arm would then accelerate as if the limit belonged to its mechanics, and the tool would yield.
    With c = 100 the solution first uses the freedom that the tool leaves, but does not accelerate heavy joints hard for
    a light one.

    Bounds on the accelerations are meant for those that actually follow. If a hand presses on something, the wanted
    accelerations do not follow. A bound that binds is therefore relaxed by the acceleration that the environment took
    away in the last period. The last period's state is remembered for that, too.
    """

    def __init__(
        self,
        arm: ArmModel,
        tasks: Sequence[Task],
        limits: Collection[str | Limit] | None = None,
        solver: str | Solver = "daqp",
        rate: float = 500.0,
        *,
        friction: FrictionCompensation | bool = True,
        priority: float = TOOL_PRIORITY,
    ) -> None:
        """Join tasks and limits; the other arguments and errors are those of `InverseDynamics`.

        Args:
            arm: Arm to control.
            tasks: Tasks, of which at most one is a `PostureTask` or a `DampingTask`.
            limits: Limits.
            solver: Name of the solver, or an object that solves.
            rate: Control rate [Hz].
            friction: Whether to feed the arm's joint friction forward, or the feed-forward itself.
            priority: Cost c of the tasks' part of a deviation, over that of the freedom that they leave.
        """
        super().__init__(arm, tasks, limits, solver, rate, friction=friction)
        postures = [task for task in self.tasks if isinstance(task, PostureTask | DampingTask)]
        if len(postures) != 1 or len(self.tasks) < 2:
            raise ConfigurationError(
                "InertiaWeightedDynamics takes one PostureTask or DampingTask, and tasks besides it; add up the others"
            )
        self._posture_task = postures[0]
        self._posture = self.tasks.index(postures[0])
        self._priority = priority
        self._usual = None
        self._last: _Period | None = None

    def reset(self) -> None:
        """Forget the last period, as before a new motion."""
        super().reset()
        self._last = None

    def _assemble(self, observation: Observation, state: ArmState, disturbance: Array | None) -> Assembly:
        state = self._complete(observation, state)
        n, posture = self.arm.nv, self._posture_task
        objectives = self._tasks.rows(state)
        A, b = _stacked([rows for index, rows in enumerate(objectives) if index != self._posture])
        weight: float = posture.weight
        m = len(b)
        inertia, compliance, shown, factor = np.empty((n, n)), np.empty((n, m)), np.empty((m, m)), np.empty((m, m))
        cholesky(state.M, inertia)
        mobility(inertia, A, compliance, shown)
        shown[np.arange(m), np.arange(m)] += weight
        if not cholesky(shown, factor):
            factor.fill(np.nan)
        free: Array = objectives[self._posture].b / sqrt(weight)
        optimum = _consistent(A, b, free, compliance, factor)
        friction = None
        if self.friction is not None:
            asked = self._tasks.velocities(objectives, self.friction.error_rate)
            pull = asked.pop(self._posture) / sqrt(weight)
            friction = self.friction.torque(_consistent(A, np.concatenate(asked), pull, compliance, factor))
        bias, state = state.h, self._with_feed_forward(state, friction, disturbance)
        rows = self._limits.rows(state)
        columns, H, f = np.array(A), np.empty((n, n)), np.empty(n)
        solve_factored_columns(factor, columns)
        weighted_metric(state.M, A, columns, self._priority, H)
        multiply(H, optimum, f)
        np.negative(f, out=f)
        program = QuadraticProgram(H, f, rows.G, rows.lower, rows.upper)
        assembly = Assembly(observation.time, state, bias, program, rows, friction, optimum)
        reserve = np.where(rows.on_torque, 0.0, FRICTION_RESERVE)
        if not smallest_margin(optimum, rows.G, rows.lower + reserve, rows.upper - reserve) > 0.0:
            self._relax_bounds(assembly)
        return assembly

    def _remember(self, assembly: Assembly, output: ControllerOutput) -> None:
        self._last = _Period(assembly.time, assembly.state, output.acceleration, assembly.friction)

    def _relax_bounds(self, assembly: Assembly) -> None:
        """Move the bounds outwards by the acceleration that the environment took away in the last period.

        They never move inwards, because such a bound would answer an impact with the full torque.
        """
        last = self._last
        if last is None or not MIN_ELAPSED < (assembly.time - last.time) * self.rate < MAX_ELAPSED:
            return
        arm, v, rows, n = self.arm, assembly.state.v, assembly.limits, self.arm.nv
        rest, factor = np.empty(n), np.empty((n, n))
        coulomb_torque(v, arm.friction_coulomb, EXPECTED_FRICTION_SCALE, rest)
        expected = -rest - arm.friction_viscous * v
        if last.friction is not None:
            expected += last.friction
        cholesky(last.state.M, factor)
        solve_factored(factor, expected)
        taken = (v - last.state.v) * self.rate - (last.acceleration + expected)
        # Friction alone can take this much from a joint that it holds, so the environment need not be the cause.
        inverse = np.eye(n)
        solve_factored_columns(factor, inverse)
        held = arm.friction_coulomb * inverse.diagonal()
        change, still = np.empty(len(rows.lower)), np.empty(len(rows.lower))
        change[:n], still[:n] = taken, held
        multiply(rows.G, taken, change[n:])
        multiply(np.abs(rows.G), held, still[n:])
        change[rows.on_torque] = still[rows.on_torque] = 0.0
        np.subtract(rows.lower, np.maximum(change - still, 0.0), out=rows.lower)
        np.subtract(rows.upper, np.minimum(change + still, 0.0), out=rows.upper)


def _stacked(rows: Sequence[Objective]) -> Objective:
    if len(rows) == 1:
        return rows[0]
    return Objective(np.concatenate([A for A, _ in rows]), np.concatenate([b for _, b in rows]))


def _consistent(A: Array, b: Array, free: Array, compliance: Array, factor: Array) -> Array:
    """Return free + M⁻¹ Aᵀ F (nv,) with F = L (b - A free), L by its factor: what the rows ask for, and else `free`."""
    force, found = np.empty(len(b)), np.empty(len(free))
    multiply(A, free, force)
    np.subtract(b, force, out=force)
    solve_factored(factor, force)
    multiply(compliance, force, found)
    found += free
    return found
