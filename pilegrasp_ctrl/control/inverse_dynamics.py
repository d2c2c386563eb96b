"""From a wanted tool acceleration to joint torques under limits: what every controller shares."""

from __future__ import annotations

from collections.abc import Collection
from time import perf_counter

import numpy as np

from ..arm_model import ArmModel
from ..arm_state import ArmState
from ..exceptions import ConfigurationError, SolverError
from ..limits.acceleration_bounds import AccelerationBounds, AffineLimit
from ..limits.position_limit import PositionLimit
from ..limits.torque_limit import TorqueLimit
from ..limits.velocity_limit import VelocityLimit
from ..tasks.frame_task import FrameTask
from ..tasks.objective import Objective
from ..tasks.posture_task import PostureTask
from ..types import Array, Command, ControllerOutput
from .linear_algebra import solve_positive_definite
from .qp import QuadraticProgram, Solution, make_solver, solve

LIMITS = ("torque", "velocity", "position")

_ACTIVE = 1e-6
_FALLBACK_DAMPING = 10.0


class InverseDynamics:
    """A quadratic program in the joint accelerations a.

        minimise    |W^½ (J a + Jdot_v - wanted)|² + w |a - a_posture|²
        subject to  bounds on a from velocity and position limits,    |M a + h + feed-forward| <= torque limit

    The torque rows are hard. The bounds on a are hard too where that is possible; where a saturated arm cannot meet
    them they are softened for that period, so that there is always a torque. Buffers are reused between calls, so one
    instance serves one thread.
    """

    def __init__(
        self,
        arm: ArmModel,
        task: FrameTask,
        posture: PostureTask,
        limits: Collection[str] = LIMITS,
        solver: str = "daqp",
        rate: float = 500.0,
    ) -> None:
        """Allocate the program.

        Raises:
            ConfigurationError: where a limit or the solver is unknown, the rate is not positive, or the posture does
                not fit the arm.
        """
        if unknown := [name for name in limits if name not in LIMITS]:
            raise ConfigurationError(f"no limit {unknown[0]!r}; the limits are {', '.join(LIMITS)}")
        if not 0.0 < rate < np.inf:
            raise ConfigurationError(f"rate = {rate} must be a positive frequency [Hz]")
        n = arm.nv
        if posture.target is not None and posture.target.shape != (n,):
            raise ConfigurationError(f"the posture has {len(posture.target)} entries; {arm.name} has {n} joints")
        self.arm, self._task, self._posture = arm, task, posture
        affine: list[AffineLimit] = []
        if "velocity" in limits:
            affine.append(VelocityLimit(arm, rate))
        if "position" in limits:
            affine.append(PositionLimit(arm, rate))
        self._bounds = AccelerationBounds(affine, n)
        self._torque_limit = TorqueLimit(arm) if "torque" in limits else None
        self._solver = make_solver(solver)
        # Everything affine in the state is one product: bounds, then targets for velocities, then for accelerations.
        # The tool's six rows of each target are not affine and are written over the product's zeros.
        rows = 6 + n
        matrices, offsets = posture.affine(n)
        tool_matrix, tool_offset = np.zeros((6, 2 * n)), np.zeros(6)
        self._matrix = np.vstack((self._bounds.matrix, tool_matrix, matrices[0], tool_matrix, matrices[1]))
        self._offset = np.concatenate((self._bounds.offset, tool_offset, offsets[0], tool_offset, offsets[1]))
        self._values = np.zeros(len(self._offset))
        self._bound_values = self._bounds.split(self._values[: -2 * rows])
        targets = self._values[-2 * rows :].reshape(2, rows)
        self._posture_targets = targets[:, 6:]
        self._velocity_target, self._tool_velocity = targets[0], targets[0, :6]
        self._A, self._c = np.zeros((rows, n)), targets[1]
        self._A[6:] = posture.sqrt_weight * np.eye(n)
        self._A_transposed = self._A.T
        self._tool_rows = Objective(self._A[:6], self._c[:6])
        bounds = np.stack((np.full(2 * n, -np.inf), np.full(2 * n, np.inf)))
        self._program = QuadraticProgram(np.zeros((n, n)), np.zeros(n), np.zeros((n, n)), bounds[0], bounds[1])
        self._lower, self._upper = bounds[0, :n], bounds[1, :n]
        self._torque_bounds = bounds[:, n:]

    @property
    def program(self) -> QuadraticProgram:
        """The program as it was last assembled and solved; its arrays are reused by the next period."""
        return self._program

    def assemble(self, state: ArmState, wanted: Array, posture: Array | None = None) -> None:
        """Write the cost and the bounds on a.

        Args:
            state: the arm.
            wanted: (6,) acceleration of the tool [m/s², rad/s²].
            posture: (nv,) in place of the posture task's target [rad].

        Raises:
            ConfigurationError: where the posture has a wrong shape or holds a value that is not finite.
        """
        values = self._values
        np.dot(self._matrix, state.x, out=values)
        np.add(values, self._offset, out=values)
        if posture is not None:
            if np.shape(posture) != state.q.shape or not np.isfinite(posture).all():
                raise ConfigurationError(f"the posture must be {self.arm.nv} finite numbers; it is {posture}")
            self._posture.retarget(self._posture_targets, state.q, posture)
        self._bounds.intersect(self._bound_values, self._lower, self._upper)
        self._task.write(self._tool_rows, state, wanted)
        H, f, _, lower, upper = self._program
        np.dot(self._A_transposed, self._A, out=H)
        np.dot(self._c, self._A, out=f)
        self._program = QuadraticProgram(H, f, state.M, lower, upper)

    def joint_velocity(self, twist: Array) -> Array:
        """Return (nv,) the joint velocity that a tool twist and the posture ask for [rad/s]; after `assemble`.

        The program's own cost with velocities in place of accelerations, limits aside.
        """
        np.multiply(twist, self._task.sqrt_weight, out=self._tool_velocity)
        return solve_positive_definite(self._program.H, np.dot(self._velocity_target, self._A))

    def solve(self, state: ArmState, feedforward: Array | None = None) -> ControllerOutput:
        """Return the torques for what was assembled.

        Args:
            state: the state that was assembled.
            feedforward: (nv,) torque beside that of the accelerations, counted into the torque limits [N·m].
        """
        offset = state.h if feedforward is None else state.h + feedforward
        limit = self._torque_limit
        if limit is not None:
            limit.write(self._torque_bounds, offset)
        start = perf_counter()
        try:
            solution = solve(self._program, self._solver)
        except SolverError as error:
            return self._fallback(state, str(error), perf_counter() - start)
        elapsed = perf_counter() - start
        torque = solution.Gx + offset
        if solution.margin > _ACTIVE:
            return ControllerOutput(Command(torque), solution.x, (), elapsed)
        if limit is not None:
            # Only round-off is cut here: the rows are hard, and the solver's answer was checked against them.
            torque = np.minimum(np.maximum(torque, -limit.torque), limit.torque)
        return ControllerOutput(Command(torque), solution.x, self._active(solution), elapsed)

    def _active(self, solution: Solution) -> tuple[str, ...]:
        n = self.arm.nv
        names = []
        for side, slack in zip(("lower", "upper"), solution.slack, strict=True):
            for index in np.flatnonzero(slack < _ACTIVE).tolist():
                if index < n:
                    names.append(self._bounds.name(self._bound_values, index, side))
                else:
                    names.append(f"torque[{index - n}] {side}")
        return tuple(names)

    def _fallback(self, state: ArmState, reason: str, elapsed: float) -> ControllerOutput:
        limit = self.arm.torque_limit
        h: Array = np.nan_to_num(state.h)
        wanted: Array = np.nan_to_num(h - _FALLBACK_DAMPING * state.M.diagonal() * state.v)
        torque = np.clip(wanted, -limit, limit)
        names = [
            f"torque[{joint}] {'upper' if torque[joint] > 0.0 else 'lower'}"
            for joint in np.flatnonzero(np.abs(wanted) >= limit).tolist()
        ]
        acceleration = solve_positive_definite(state.M, torque - h)
        reason = f"{reason}; gravity compensation with damping instead"
        return ControllerOutput(Command(torque), acceleration, tuple(names), elapsed, reason)
