"""From a wanted tool acceleration to joint torques under limits: what every controller shares."""

from __future__ import annotations

from collections.abc import Collection
from time import perf_counter

import numpy as np

from ..arm_model import ArmModel
from ..arm_state import ArmState
from ..exceptions import ConfigurationError, SolverError
from ..limits.acceleration_bounds import AccelerationBounds, AffineLimit
from ..limits.constraint import Constraint
from ..limits.position_limit import PositionLimit
from ..limits.torque_limit import TorqueLimit
from ..limits.velocity_limit import VelocityLimit
from ..tasks.frame_task import FrameTask
from ..tasks.objective import Objective
from ..tasks.posture_task import PostureTask
from ..types import Array, Command, ControllerOutput
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
        self._solver = make_solver(solver, n, n)
        self.program = QuadraticProgram.empty(n, n)
        self._torque_rows = Constraint(self.program.G, self.program.lower[n:], self.program.upper[n:])
        self._A, self._b = np.zeros((6 + n, n)), np.zeros(6 + n)
        self._tool_rows = Objective(self._A[:6], self._b[:6])
        self._posture_rows = Objective(self._A[6:], self._b[6:])
        posture.write_matrix(self._posture_rows)

    def assemble(self, state: ArmState, wanted: Array, posture: Array | None = None) -> None:
        """Write the cost and the bounds on a, for the wanted tool acceleration (6,) and a posture (nv,)."""
        H, f, G, lower, upper = self.program
        n = self.arm.nv
        self._task.write(self._tool_rows, state, wanted)
        self._posture.write(self._posture_rows, state.q, state.v, posture)
        np.dot(self._A.T, self._A, out=H)
        np.dot(self._b, self._A, out=f)
        np.negative(f, out=f)
        G[:] = state.M
        self._bounds.write(lower[:n], upper[:n], state.q, state.v)

    def joint_velocity(self, state: ArmState, twist: Array, posture: Array | None = None) -> Array:
        """Return (nv,) the joint velocity that a tool twist and the posture ask for [rad/s]; after `assemble`.

        The program's own cost with velocities in place of accelerations, limits aside.
        """
        target = np.empty(len(self._b))
        np.multiply(twist, self._task.sqrt_weight, out=target[:6])
        self._posture.write_velocity(target[6:], state.q, posture)
        return np.linalg.solve(self.program.H, np.dot(target, self._A))

    def solve(self, state: ArmState, feedforward: Array | None = None) -> ControllerOutput:
        """Return the torques for what was assembled.

        Args:
            state: the state that was assembled.
            feedforward: (nv,) torque beside that of the accelerations, counted into the torque limits [N·m].
        """
        offset = state.h if feedforward is None else state.h + feedforward
        if self._torque_limit is not None:
            self._torque_limit.write(self._torque_rows, offset)
        start = perf_counter()
        try:
            solution = solve(self.program, self._solver)
        except SolverError as error:
            return self._fallback(state, str(error), perf_counter() - start)
        elapsed = perf_counter() - start
        torque = solution.Gx + offset
        active: tuple[str, ...] = ()
        if np.minimum.reduce(solution.slack, axis=None) < _ACTIVE:
            active = self._active(solution)
            if self._torque_limit is not None:
                limit = self._torque_limit.torque
                torque = np.minimum(np.maximum(torque, -limit), limit)
        return ControllerOutput(Command(torque), solution.x, active, elapsed)

    def _active(self, solution: Solution) -> tuple[str, ...]:
        n = self.arm.nv
        names = []
        for side, slack in zip(("lower", "upper"), solution.slack, strict=True):
            for index in np.flatnonzero(slack < _ACTIVE).tolist():
                names.append(self._bounds.name(index, side) if index < n else f"torque[{index - n}] {side}")
        return tuple(names)

    def _fallback(self, state: ArmState, reason: str, elapsed: float) -> ControllerOutput:
        limit = self.arm.torque_limit
        h = np.nan_to_num(state.h)
        wanted = np.nan_to_num(h - _FALLBACK_DAMPING * state.M.diagonal() * state.v)
        torque = np.clip(wanted, -limit, limit)
        names = [
            f"torque[{joint}] {'upper' if torque[joint] > 0.0 else 'lower'}"
            for joint in np.flatnonzero(np.abs(wanted) >= limit).tolist()
        ]
        acceleration = np.linalg.solve(state.M, torque - h)
        reason = f"{reason}; gravity compensation with damping instead"
        return ControllerOutput(Command(torque), acceleration, tuple(names), elapsed, reason)
