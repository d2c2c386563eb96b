"""Inverse dynamics under limits: joint torques for a wanted tool acceleration; every controller uses it."""

from __future__ import annotations

from collections.abc import Collection
from time import perf_counter
from typing import Any, ClassVar

import numpy as np
from eigenpy import LLT  # type: ignore[import-untyped]

from ..arm.friction import coulomb_torque
from ..arm.model import ArmModel
from ..arm.state import ArmState
from ..exceptions import ConfigurationError, SolverError
from ..limits.acceleration_bounds import AccelerationBounds, AffineLimit
from ..limits.motion_limits import PositionLimit, VelocityLimit, braking_acceleration
from ..limits.torque_limit import TorqueLimit
from ..qp.program import QuadraticProgram, Solution, make_solver, solve
from ..tasks.frame_task import FrameTask, Objective
from ..tasks.posture_task import PostureTask
from ..types import Array, Command, ControllerOutput

LIMITS = ("torque", "velocity", "position")
"""Names of the limits, in arguments and in `active_limits`."""

FRICTION_RESERVE = 200.0
"""Distance to a bound beyond which joint friction cannot move a light joint across it [rad/s²]; chosen."""
EXPECTED_FRICTION_SCALE = 0.05
"""Joint velocity at which three quarters of the Coulomb friction are expected near a limit [rad/s]; chosen."""
ACTIVE = 1e-6
"""Distance below which a limit is active [rad/s², N·m]; chosen below `FEASIBILITY`, the tolerance of an answer."""
_FALLBACK_DAMPING = 10.0
"""Damping of the joints over their inertia, in periods without a solution [1/s]; chosen."""
_DEMAND = 1.25
"""Largest acceleration that a bound may demand, over the joint's braking acceleration; chosen.

On the border of the states from which a joint can brake, a bound demands exactly the braking acceleration. Beyond the
border it demands slightly more.
"""


class InverseDynamics:
    """A quadratic program in the joint accelerations a.

        minimise    |W^½ (J a + Jdot_v - wanted)|² + w |a - a_posture|²
        subject to  bounds on a from velocity and position limits,    |S (M a + h + feed-forward)| <= torque limit

    S is the identity except for joints that share motors; see `TorqueLimit`.

    The torque rows are hard. The bounds on a are hard too, if a solution exists. If a saturated arm cannot meet them,
    they are softened for that period, so there is always a torque. Buffers are reused between calls, so use one
    instance in one thread only.

    Attributes:
        arm: Arm to control.
        solver: Solver of the program.
        posture_root: Square root of the posture's weight.
    """

    _memory: ClassVar[tuple[str, ...]] = ()
    """Names of the attributes that outlast a period."""

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

        Args:
            arm: Arm to control.
            task: Task of the tool.
            posture: Task of the posture.
            limits: Limits to enforce, of "torque", "velocity" and "position".
            solver: Name of the solver.
            rate: Control rate [Hz].

        Raises:
            ConfigurationError: A limit or the solver is unknown, the rate is not positive, or the posture does not fit
                the arm.
        """
        if unknown := [name for name in limits if name not in LIMITS]:
            raise ConfigurationError(f"no limit {unknown[0]!r}; the limits are {', '.join(LIMITS)}")
        if not 0.0 < rate < np.inf:
            raise ConfigurationError(f"rate = {rate} must be a positive frequency [Hz]")
        n = arm.nv
        if posture.target is not None and posture.target.shape != (n,):
            raise ConfigurationError(f"the posture has {len(posture.target)} entries; {arm.name} has {n} joints")
        self._arguments = arm, task, posture, tuple(limits), solver, rate
        self.arm, self._task, self._posture = arm, task, posture
        self.posture_root = posture.sqrt_weight
        affine: list[AffineLimit] = []
        braking = braking_acceleration(arm)
        self._period, self._nearest = 1.0 / rate, -np.inf
        self._has_friction = bool(arm.friction_coulomb.any() or arm.friction_viscous.any())
        if "velocity" in limits:
            affine.append(VelocityLimit(arm, rate))
        if "position" in limits:
            affine.append(PositionLimit(arm, rate, braking=braking))
        self._bounds = AccelerationBounds(affine, n, _DEMAND * braking)
        self._fallback_limit = TorqueLimit(arm)
        self._torque_limit = self._fallback_limit if "torque" in limits else None
        self.solver = make_solver(solver)
        # One product gives everything affine in the state: bounds, target velocities and target accelerations. The
        # tool's six rows of each target are not affine; they overwrite zeros of the product.
        rows = 6 + n
        matrices, offsets = posture.affine(n)
        affine_targets = np.zeros((2, rows, 2 * n + 1))
        affine_targets[:, 6:, :-1], affine_targets[:, 6:, -1] = matrices, offsets
        self._matrix = np.vstack((self._bounds.matrix, *affine_targets))
        self._values = np.zeros(len(self._matrix))
        self._blocks = self._bounds.split(self._values[: -2 * rows])
        targets = self._values[-2 * rows :].reshape(2, rows)
        self._posture_targets = targets[:, 6:]
        self._velocity_target, self._tool_velocity = targets[0], targets[0, :6]
        self._A, self._c = np.zeros((rows, n)), targets[1]
        self._A[6:] = posture.sqrt_weight * np.eye(n)
        self._A_transposed = self._A.T
        self._tool_rows = Objective(self._A[:6], self._c[:6])
        lower, upper = np.full(2 * n, -np.inf), np.full(2 * n, np.inf)
        self._program = QuadraticProgram(np.zeros((n, n)), np.zeros(n), np.zeros((n, n)), lower, upper)
        # Views that are made once are cheaper than slices in every period.
        self._acceleration_bounds = lower[:n], upper[:n]
        self._torque_bounds = lower[n:], upper[n:]

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.arm!r}, {self._task!r}, solver={self.solver.name!r})"

    def __reduce__(self) -> tuple[Any, ...]:
        """Copy and pickle by the arguments: views into one buffer would come apart if each were copied."""
        return type(self), self._arguments, {name: getattr(self, name) for name in self._memory}

    def is_far(self, nearest: float) -> bool:
        """Return whether every bound is far enough away that joint friction cannot reach it. NaN counts as near.

        Args:
            nearest: Nearest bound, as `AccelerationBounds.intersect` returns it [rad/s²].
        """
        return nearest <= (-FRICTION_RESERVE if self._has_friction else np.inf)

    def constants(self) -> tuple[Array, Array]:
        """Return the stacked matrix (rows, 2 nv + 1) of all that is affine in the state, and S (nv, nv)."""
        limit = self._torque_limit
        return self._matrix, np.eye(self.arm.nv) if limit is None or limit.matrix is None else limit.matrix

    def limits(self) -> Array:
        """Return (3, nv) the limits of S tau [N·m] and the largest demands of lower and upper bounds [rad/s²]."""
        limit = self._torque_limit
        torque = np.full(self.arm.nv, np.inf) if limit is None else limit.limit
        return np.vstack((torque, self._bounds.demand.reshape(2, -1)))

    @property
    def program(self) -> QuadraticProgram:
        """The program that was assembled and solved last; the next period reuses its arrays."""
        return self._program

    def assemble(self, state: ArmState, wanted: Array, posture: Array | None = None) -> None:
        """Write the cost and the bounds on a.

        Args:
            state: State of the arm.
            wanted: (6,) Wanted acceleration of the tool [m/s², rad/s²].
            posture: (nv,) Joint positions in place of the posture task's target [rad].

        Raises:
            ConfigurationError: The posture has a wrong shape or a value that is not finite.
        """
        self._matrix.dot(state.x, out=self._values)
        if posture is not None:
            if np.shape(posture) != state.q.shape or not np.isfinite(posture).all():
                raise ConfigurationError(f"the posture must be {self.arm.nv} finite numbers; it is {posture}")
            self._posture.retarget(self._posture_targets, state.q, posture)
        self._nearest = self._bounds.intersect(self._blocks, *self._acceleration_bounds)
        self._task.write(self._tool_rows, state, wanted)
        _, _, _, lower, upper = self._program
        A, limit = self._A, self._torque_limit
        G = state.M if limit is None else limit.rows(state.M)
        self._program = QuadraticProgram(self._A_transposed.dot(A), self._c.dot(A), G, lower, upper)

    def joint_velocity(self, twist: Array) -> Array:
        """Return (nv,) the joint velocity that a tool twist and the posture ask for [rad/s].

        It minimises the program's cost with velocities in place of accelerations, without the limits. Call `assemble`
        first.
        """
        np.multiply(twist, self._task.sqrt_weight, out=self._tool_velocity)
        velocity: Array = LLT(self._program.H).solve(self._velocity_target.dot(self._A))
        return velocity

    def solve(self, state: ArmState, friction: Array | None = None, cancelled: Array | None = None) -> ControllerOutput:
        """Return the torques of the program that was assembled.

        Both torques below are added to that of the accelerations, and they count in the torque limits.

        Args:
            state: State that was assembled.
            friction: (nv,) Torque against the expected friction [N·m].
            cancelled: (nv,) Torque against a known torque of the environment on the joints [N·m].
        """
        offset = state.h if friction is None else state.h + friction
        if cancelled is not None:
            offset = offset + cancelled
        if self._has_friction and self._nearest > -FRICTION_RESERVE:
            return self._solve_near_limits(state, offset, friction)
        return self._solve(state, offset)

    def _solve_near_limits(self, state: ArmState, offset: Array, compensated: Array | None) -> ControllerOutput:
        """Solve for bounds on the accelerations that follow after friction has acted.

        The difference between friction and its feed-forward moves the joints in addition to the program's
        accelerations. Next to a limit, friction that changes its sign with the motion would move a light joint beyond.
        Friction acts against the present motion, or against the motion that a first solution predicts. The bounds of
        the second solution hold for both, because the motion may differ from the prediction.
        """
        arm = self.arm
        lower, upper = self._acceleration_bounds
        wanted_lower, wanted_upper = lower.copy(), upper.copy()
        v = state.v
        least, most = np.full(len(v), np.inf), np.full(len(v), -np.inf)
        for _ in range(2):
            rest = -coulomb_torque(v, arm.friction_coulomb, EXPECTED_FRICTION_SCALE) - arm.friction_viscous * state.v
            if compensated is not None:
                rest += compensated
            drift = LLT(state.M).solve(rest)
            np.minimum(least, drift, out=least)
            np.maximum(most, drift, out=most)
            np.subtract(wanted_lower, least, out=lower)
            np.subtract(wanted_upper, most, out=upper)
            np.maximum(upper, lower, out=upper)
            output = self._solve(state, offset)
            v = state.v + self._period * (output.acceleration + drift)
        return output

    def _solve(self, state: ArmState, offset: Array) -> ControllerOutput:
        limit = self._torque_limit
        if limit is not None:
            limit.write(*self._torque_bounds, offset)
        start = perf_counter()
        try:
            solution = solve(self._program, self.solver)
        except SolverError as error:
            return self._fallback(state, str(error), perf_counter() - start)
        elapsed = perf_counter() - start
        torque = state.M.dot(solution.x)
        torque += offset
        if solution.margin > ACTIVE:
            return ControllerOutput(Command(torque), solution.x, (), elapsed)
        if limit is not None:
            # This cuts only round-off: the rows are hard, and the solver's answer was checked against them.
            torque = limit.cut(torque)
        return ControllerOutput(Command(torque), solution.x, self._active(solution), elapsed)

    def _active(self, solution: Solution) -> tuple[str, ...]:
        n = self.arm.nv
        names = []
        for side, slack in zip(("lower", "upper"), solution.slack, strict=True):
            for index in np.flatnonzero(slack < ACTIVE).tolist():
                if index < n:
                    names.append(self._bounds.name(self._blocks, index, side))
                elif self._torque_limit is not None:
                    names.append(f"{self._torque_limit.row_names[index - n]} {side}")
        return tuple(names)

    def _fallback(self, state: ArmState, reason: str, elapsed: float) -> ControllerOutput:
        limit = self._fallback_limit
        h: Array = np.nan_to_num(state.h)
        wanted: Array = np.nan_to_num(h - _FALLBACK_DAMPING * state.M.diagonal() * state.v)
        torque = limit.cut(wanted)
        rows = wanted if limit.matrix is None else limit.matrix.dot(wanted)
        names = [
            f"{limit.row_names[row]} {'upper' if rows[row] > 0.0 else 'lower'}"
            for row in np.flatnonzero(np.abs(rows) >= limit.limit).tolist()
        ]
        acceleration = LLT(state.M).solve(torque - h)
        reason = f"{reason}; gravity compensation with damping instead"
        return ControllerOutput(Command(torque), acceleration, tuple(names), elapsed, reason)
