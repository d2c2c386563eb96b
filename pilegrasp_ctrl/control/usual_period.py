"""The period of motion control far from all limits, in one compiled call instead of many."""

from __future__ import annotations

from time import perf_counter
from typing import Any

import numpy as np

from ..arm.model import ArmModel
from ..arm.state import ArmState
from ..kernels.algebra import add_multiplied_transposed, add_normal_equations
from ..kernels.period import optimum_and_bounds, task_equations, usual_period
from ..limits.motion_limits import PositionLimit, VelocityLimit
from ..limits.torque_limit import TorqueLimit
from ..qp.daqp_solver import DaqpSolver
from ..qp.program import QuadraticProgram
from ..qp.solvers import Solver
from ..tasks.frame_task import FrameTask
from ..tasks.linear_task import LinearTask
from ..tasks.pose_task import FRICTION_APPROACH
from ..types import Array, Command, ControllerOutput
from .assembly import Assembly
from .friction_compensation import FrictionCompensation
from .limit_rows import CheckedLimits
from .task_rows import CheckedTasks


class UsualPeriod:
    """A `FrameTask` of the tool, a task of the joints and any others, within the limits that every arm has.

    It calls the kernels that tasks and limits call themselves, in the same order, and so gives the same bits. Where the
    tool's acceleration may have to be reduced, it leaves the period to the tasks.
    """

    def __init__(
        self,
        tasks: CheckedTasks,
        limits: CheckedLimits,
        friction: FrictionCompensation,
        reserve: float,
        active: float,
    ) -> None:
        """Take the parts of a controller.

        Args:
            tasks: Tasks, of which the first is a `FrameTask` of the tool and the second a `LinearTask`.
            limits: Limits of torque, velocity and position.
            friction: Feed-forward against joint friction, which may be zero.
            reserve: Distance to a bound below which the period is not the usual one [rad/s²].
            active: Distance to a limit below which it is active [rad/s², N·m].
        """
        self._tasks, self._limits, self._friction, self._active = tasks, limits, friction, active
        self._others = tasks.tasks[2:]
        n = tasks.tasks[0].arm.nv  # type: ignore[attr-defined]
        self._buffers = np.zeros((2, n, n)), np.zeros((8, n)), np.zeros((2, 2 * n))
        matrices, vectors, _ = self._buffers
        self._equations = matrices[0], vectors[0], vectors[1]
        self._reserve = reserve
        self._arm: ArmModel | None = None
        self._frame_numbers: object = None
        self._axes: tuple[Any, ...] = ()
        self._bounds: tuple[Any, ...] = ()

    def _axes_of(self, frame: FrameTask) -> tuple[Any, ...]:
        """Return `axes` and `shape` of the kernels for the frame's present gains."""
        if frame.numbers is not self._frame_numbers:
            self._frame_numbers = frame.numbers
            axes, shape = frame.numbers
            self._axes = axes, np.array([*shape, self._friction.error_rate, *FRICTION_APPROACH])
        return self._axes

    def _bounds_of(self, arm: ArmModel) -> tuple[Any, ...]:
        """Return `S`, `bounds` and `margins` of the kernels for an arm with its present payload."""
        if arm is not self._arm:
            self._arm, friction = arm, self._friction
            torque, velocity, position = self._limits.limits
            speed, least, *ahead = velocity.numbers(arm)  # type: ignore[attr-defined]
            lower, upper, coulomb, gravity, share, braking, retreat, *way = position.numbers(arm)  # type: ignore[attr-defined]
            rows = [friction.coulomb, friction.viscous, friction.velocity_limit, speed, least, lower, upper, coulomb]
            rows += [gravity, braking, retreat, torque.limit]  # type: ignore[attr-defined]
            margins = np.array([friction.scale, *ahead, share, *way, self._reserve])
            self._bounds = torque.S, np.array(rows), margins  # type: ignore[attr-defined]
        return self._bounds

    @classmethod
    def of(
        cls,
        tasks: CheckedTasks,
        limits: CheckedLimits,
        friction: FrictionCompensation,
        solver: Solver,
        reserve: float,
        active: float,
    ) -> UsualPeriod | None:
        """Return the compiled period of a controller; None if its parts are others. Arguments as in `__init__`."""
        frame, joints, *others = (*tasks.tasks, None, None)
        if type(frame) is not FrameTask or frame.frame != frame.arm.tool_frame or not isinstance(solver, DaqpSolver):
            return None
        if not isinstance(joints, LinearTask) or not joints.is_linear:
            return None
        if any(hasattr(task, "torque") for task in others):
            return None
        if tuple(type(limit) for limit in limits.limits) != (TorqueLimit, VelocityLimit, PositionLimit):
            return None
        return cls(tasks, limits, friction, reserve, active)

    def solve_or_assemble(self, time: float, state: ArmState) -> ControllerOutput | Assembly | None:
        """Return the torques for one control period.

        If a limit is active or near, return the program instead. Return None if the tasks have to be asked.
        """
        frame, joints, *_ = self._tasks.checked()
        _, q, v, M, h, J, Jdot_v, p, R, twist, arm, *_ = state
        target = frame.require_target()
        pose, n = target.pose, len(h)
        x, torque = np.empty(n), np.empty(n)
        reference = pose.translation, pose.rotation, target.twist, target.acceleration
        tasks = *reference, *self._axes_of(frame), *joints.numbers
        bounds, (matrices, vectors, ranges) = self._bounds_of(arm), self._buffers
        start = perf_counter()
        if self._others:
            if not task_equations(q, v, J, Jdot_v, p, R, twist, *tasks, matrices, vectors):
                return None
            self._add_others(state)
            start = perf_counter()
            margin = optimum_and_bounds(q, v, M, h, *bounds, x, torque, matrices, vectors, ranges)
        else:
            margin = usual_period(
                q, v, J, Jdot_v, p, R, twist, M, h, *tasks, *bounds, x, torque, matrices, vectors, ranges
            )
        if margin > self._active:
            return ControllerOutput(Command(torque), x, (), perf_counter() - start)
        if margin == -np.inf:
            return None
        return self._assembly(time, state, x)

    def _add_others(self, state: ArmState) -> None:
        H, f, g = self._equations
        tasks = self._tasks
        for task in self._others:
            A, b = tasks.rows_of(task, state)
            add_normal_equations(A, b, H, f)
            add_multiplied_transposed(A, tasks.velocity_of(task, b, self._friction.error_rate), g)

    def _assembly(self, time: float, state: ArmState, optimum: Array) -> Assembly:
        """Return the program in copies of the buffers, which the next period reuses."""
        (H, G), (f, _, friction, held, *boxes), (lower, upper) = (buffer.copy() for buffer in self._buffers)
        program, bias = QuadraticProgram(H, f, G, lower, upper), state.h
        rows = self._limits.of(G, lower, upper, ((boxes[0], boxes[1]), (boxes[2], boxes[3])))
        return Assembly(time, state._replace(h=held), bias, program, rows, friction, optimum)
