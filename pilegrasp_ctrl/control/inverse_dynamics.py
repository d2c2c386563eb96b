"""Inverse dynamics: joint torques that serve a list of tasks within a list of limits; every controller uses it."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ..arm.fitting import check_arm, check_observation, check_rate
from ..arm.model import ArmModel
from ..arm.state import ArmState
from ..exceptions import ConfigurationError, SolverError
from ..kernels.algebra import add_normal_equations, cholesky, solve_factored
from ..kernels.friction import allow_for_friction
from ..kernels.program import joint_torque, smallest_margin
from ..limits.limit import Limit
from ..limits.standard import read_limits
from ..qp.daqp_solver import DaqpSolver
from ..qp.problem import as_problem
from ..qp.program import QuadraticProgram, Solution, solve
from ..qp.solvers import Solver, make_solver, solver_name
from ..tasks.posture_task import DampingTask
from ..tasks.task import Task
from ..types import Array, Command, ControllerOutput, Observation
from .assembly import Assembly
from .elapsed import notice_period
from .fallback import fall_back
from .friction_compensation import FrictionCompensation, make_compensation
from .limit_rows import CheckedLimits
from .task_rows import CheckedTasks
from .usual_period import UsualPeriod

if TYPE_CHECKING:
    import qpsolvers

FRICTION_RESERVE = 200.0
"""Distance to a bound beyond which joint friction cannot move a light joint across it [rad/s²]; chosen."""
EXPECTED_FRICTION_SCALE = 0.05
"""Joint velocity at which three quarters of the Coulomb friction are expected near a limit [rad/s]; chosen."""
ACTIVE = 1e-6
"""Distance below which a limit is active [rad/s², N·m]; chosen below `FEASIBILITY`, the tolerance of an answer."""


class InverseDynamics:
    """A quadratic program in the joint accelerations a.

        minimise    Σ |A a - b|²  over the rows of the tasks,    subject to    lower <= G a <= upper  of the limits

    The torque is M a + h plus feed-forward torques. Hard limits hold always. Soft ones give way, for that period, where
    the hard ones leave no room, so there is always a torque. `docs/control.md` explains tasks and limits.

    Two things outlast a period: its time and its torque. They serve `TorqueRateLimit`, and show a period that is not
    the stated one; `reset` forgets them. A copy or a pickle of a controller gives the same torques as the controller.
    Threads may share an arm, but not a controller, a task or a limit.

    Attributes:
        arm: Arm to control.
        rate: Control rate [Hz].
        solver: Solver of the program.
        friction: Feed-forward against joint friction; None without one.
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
    ) -> None:
        """Join tasks and limits.

        Args:
            arm: Arm to control.
            tasks: Tasks; their weights say which matters more. Unless one of them is `regular`, as a `PostureTask` is,
                a `DampingTask` is added, so that the motion that the tasks leave free dies out.
            limits: Limits, objects or names out of "torque", "velocity" and "position"; all three by default.
            solver: Name of the solver, or an object that solves.
            rate: Rate at which you call `step` [Hz].
            friction: Whether to feed the arm's joint friction forward, or the feed-forward itself.

        Raises:
            ConfigurationError: A task, a limit or the solver is unknown or does not fit the arm or the rate, or gains
                diverge at this rate.
        """
        check_arm(arm, type(self).__name__)
        self.arm = self._empty_arm = arm
        self.rate = check_rate(rate)
        if isinstance(tasks, str) or not isinstance(tasks, Collection):
            raise ConfigurationError(f"tasks = {tasks!r:.80} must be a list of tasks, such as [FrameTask(arm)]")
        tasks = list(tasks)
        if tasks and not any(getattr(task, "regular", False) for task in tasks):
            tasks.append(DampingTask(arm))
        self._tasks = CheckedTasks(tasks, arm, self.rate)
        self._limits = CheckedLimits(read_limits(arm, limits, self.rate), arm.nv)
        self.solver = make_solver(solver)
        self.friction = make_compensation(arm, friction)
        self._has_friction = bool(arm.friction_coulomb.any() or arm.friction_viscous.any())
        reserve = FRICTION_RESERVE if self._has_friction else -np.inf
        parts = self._tasks, self._limits, self.friction or FrictionCompensation(arm, gain=0.0), self.solver
        self._usual = UsualPeriod.of(*parts, reserve, ACTIVE)
        self._time: float | None = None
        self._torque: Array | None = None

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.arm!r}, {list(self.tasks)!r}, solver={self.solver_name!r})"

    @property
    def tasks(self) -> tuple[Task, ...]:
        """Tasks of the controller."""
        return self._tasks.tasks

    @property
    def solver_name(self) -> str:
        """Name of the solver."""
        return solver_name(self.solver)

    @property
    def limits(self) -> tuple[Limit, ...]:
        """Limits of the controller; where two contradict each other, the first one wins."""
        return self._limits.limits

    def reset(self) -> None:
        """Forget time and torque of the last period, as before a new motion."""
        self._time = self._torque = None

    def remember(self, time: float, torque: Array) -> None:
        """State the time [s] and the torque (nv,) [N·m] of the last period, where another torque was commanded."""
        self._time, self._torque = time, torque

    def set_payload(self, mass: float, center_of_mass: ArrayLike, inertia: ArrayLike | None = None) -> None:
        """Replace the payload that the hand carries from now on, as after a grasp; a mass of zero takes it away.

        Args:
            mass: Mass [kg].
            center_of_mass: (3,) Centre of mass, in the axes of the tool frame [m].
            inertia: (3, 3) Inertia about the centre of mass [kg·m²]; that of a point by default.

        Raises:
            ModelError: The mass is negative, or a value is not finite.
            ConfigurationError: A limit cannot be kept with this payload; the former payload stays.
        """
        arm = self._empty_arm if mass == 0.0 else self._empty_arm.with_payload(mass, center_of_mass, inertia)
        self._limits.check(arm)
        self.arm = arm

    def step(
        self, observation: Observation, state: ArmState | None = None, disturbance: Array | None = None
    ) -> ControllerOutput:
        """Return the torques for one control period.

        Args:
            observation: Measurement of the arm.
            state: `controller.arm.update(observation.q, observation.v)`, if you have it already.
            disturbance: (nv,) Torque of the environment on the joints [N·m], as `DisturbanceObserver` estimates it. It
                is cancelled within the torque limits. Do not give it in contact, because it would work against the
                touched object.

        Raises:
            ModelError: The observation has a wrong shape or a value that is not finite.
            ConfigurationError: A task has no target, its gains have changed to ones that diverge, or the rows of a
                task or limit have a wrong shape.
        """
        state = self._checked(observation, state)
        notice_period(self._time, observation.time, self.rate)
        usual = None
        if self._usual is not None and disturbance is None:
            usual = self._usual.solve_or_assemble(observation.time, state)
        if isinstance(usual, ControllerOutput):
            output = usual
        else:
            assembly = self._assemble(observation, state, disturbance) if usual is None else usual
            output = self.solve(assembly)
            self._remember(assembly, output)
        self._time, self._torque = observation.time, output.command.torque
        return output

    def assemble(
        self, observation: Observation, state: ArmState | None = None, disturbance: Array | None = None
    ) -> Assembly:
        """Return the program of a period, the first half of `step`; arguments and errors are those of `step`."""
        return self._assemble(observation, self._checked(observation, state), disturbance)

    def _assemble(self, observation: Observation, state: ArmState, disturbance: Array | None) -> Assembly:
        state = self._complete(observation, state)
        n = self.arm.nv
        objectives = self._tasks.rows(state)
        H, f, factor = np.zeros((n, n)), np.zeros(n), np.empty((n, n))
        for objective in objectives:
            add_normal_equations(objective.A, objective.b, H, f)
        friction, optimum = None, np.full(n, np.nan)
        if cholesky(H, factor):
            optimum = -f
            solve_factored(factor, optimum)
            if self.friction is not None:
                # These velocities minimise the cost with velocities in place of accelerations, without the limits.
                velocity = self._tasks.velocity(objectives, self.friction.error_rate)
                solve_factored(factor, velocity)
                friction = self.friction.torque(velocity)
        bias, state = state.h, self._with_feed_forward(state, friction, disturbance)
        rows = self._limits.rows(state)
        program = QuadraticProgram(H, f, rows.G, rows.lower, rows.upper)
        return Assembly(observation.time, state, bias, program, rows, friction, optimum)

    def solve(self, assembly: Assembly) -> ControllerOutput:
        """Return the torques of an assembled program, the second half of `step`."""
        if self._has_friction and assembly.limits.nearest() > -FRICTION_RESERVE:
            return self._solve_near_limits(assembly)
        return self._solve_program(assembly)

    def build_qp(self, observation: Observation) -> qpsolvers.Problem:
        """Return the quadratic program of a period, to look at or to give to a solver; nothing is remembered.

        Near a limit, an arm with friction solves the program again with bounds that allow for friction; this is the
        first one.
        """
        return as_problem(self.assemble(observation).program)

    def multipliers(self, observation: Observation) -> dict[str, float]:
        """Return the force with which each active limit holds the solution back, by its name; nothing is remembered.

        Rows of the same name count together.

        With the multipliers y, `H a + f = Gᵀ y` at the solution: positive at lower bounds, negative at upper ones. The
        library computes them from the checked answer, whatever the solver.

        Raises:
            SolverError: The program has no solution.
        """
        # This loads scipy, which takes 0.2 s.
        from ..qp.multipliers import multipliers

        assembly = self.assemble(observation)
        rows = assembly.limits
        solution = solve(assembly.program, self.solver, rows.soft)
        values = multipliers(assembly.program, solution)
        lower, upper = np.flatnonzero(values > 0.0), np.flatnonzero(values < 0.0)
        found: dict[str, float] = {}
        for name, force in zip(rows.names(lower, upper), (*values[lower], *values[upper]), strict=True):
            found[name] = found.get(name, 0.0) + float(force)
        return found

    def _remember(self, assembly: Assembly, output: ControllerOutput) -> None:
        """Remember more of a period than its time and torque."""

    def _checked(self, observation: Observation, state: ArmState | None) -> ArmState:
        """Return the state at an observation."""
        check_observation(observation)
        # A state of another model, such as that of the arm without its payload, would give wrong torques.
        if state is None or getattr(state, "arm", None) is not self.arm:
            state = self.arm.update(observation.q, observation.v)
        return state

    def _complete(self, observation: Observation, state: ArmState) -> ArmState:
        """Return the state with the torque of the last period and the measured wrench."""
        return state._replace(torque=self._torque, wrench=observation.wrench)

    def _with_feed_forward(self, state: ArmState, friction: Array | None, disturbance: Array | None) -> ArmState:
        h, added = state.h, self._tasks.torque(state)
        if friction is not None:
            h = h + friction
        if added is not None:
            h = h + added
        if disturbance is not None:
            if np.shape(disturbance) != state.q.shape or not np.isfinite(disturbance).all():
                raise ConfigurationError(f"the disturbance must be {self.arm.nv} finite numbers; it is {disturbance}")
            h = h - disturbance
        return state if h is state.h else state._replace(h=h)

    def _solve_near_limits(self, assembly: Assembly) -> ControllerOutput:
        """Solve for bounds on the accelerations that follow after friction has acted.

        The difference between friction and its feed-forward moves the joints in addition to the program's
        accelerations. Next to a limit, friction that changes its sign with the motion would move a light joint beyond.
        Friction acts against the present motion, or against the motion that a first solution predicts. The bounds of
        the second solution hold for both, because the motion may differ from the prediction. Bounds on the torque stay.
        """
        arm, state, rows = self.arm, assembly.state, assembly.limits
        wanted = rows.lower.copy(), rows.upper.copy()
        changes, drift = np.empty((2, len(rows.lower))), np.empty(arm.nv)
        changes[0], changes[1] = np.inf, -np.inf
        friction = arm.friction_coulomb, arm.friction_viscous, EXPECTED_FRICTION_SCALE
        forward = np.zeros(arm.nv) if assembly.friction is None else assembly.friction
        moving = state.v
        for last in (False, True):
            allow_for_friction(
                *(state.M, state.v, moving, *friction, forward, rows.G, rows.layout.fixed, *wanted),
                *(changes, drift, rows.lower, rows.upper),
            )
            output = self._solve_program(assembly, named=last)
            if not last:
                moving = state.v + (output.acceleration + drift) / self.rate
        return output

    def _solve_program(self, assembly: Assembly, named: bool = True) -> ControllerOutput:
        """Return the torques of a program; without `named`, the accelerations alone count."""
        state, program, rows = assembly.state, assembly.program, assembly.limits
        start = perf_counter()
        # The optimum without limits is the answer if it keeps them, for any exact solver.
        x, margin = assembly.optimum, -1.0
        if isinstance(self.solver, DaqpSolver):
            margin = smallest_margin(x, program.G, program.lower, program.upper)
        solution: Solution | None = None
        if not margin > ACTIVE:
            try:
                solution = solve(program, self.solver, rows.soft)
            except SolverError as error:
                return fall_back(state._replace(h=assembly.bias), self._cut, error, perf_counter() - start)
            x, margin = solution.x, solution.margin
        elapsed = perf_counter() - start
        torque = np.empty(self.arm.nv)
        if not named:
            return ControllerOutput(Command(torque), x, (), elapsed)
        joint_torque(x, state.M, state.h, torque)
        if solution is None or margin > ACTIVE:
            return ControllerOutput(Command(torque), x, (), elapsed)
        # Rows may share a name, as those of the guard balls of a capsule do.
        active = ([row for row, left in enumerate(slack) if left < ACTIVE] for slack in solution.slack.tolist())
        names = tuple(dict.fromkeys(rows.names(*active)))
        # This cuts only round-off: the rows are hard, and the solver's answer was checked against them.
        return ControllerOutput(Command(self._cut(torque, state)), x, names, elapsed)

    def _cut(self, torque: Array, state: ArmState) -> Array:
        for limit in self.limits:
            cut = getattr(limit, "cut", None)
            torque = torque if cut is None else cut(torque, state)
        return torque
