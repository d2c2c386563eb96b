"""Compare every installed solver on the recorded programs of two arms, as the Markdown tables of docs/solvers.md.

Usage: python docs/studies/compare_solvers.py [FILE]

`python tests/helpers/qp_programs.py record` writes such a file.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
import qpsolvers

from pilegrasp_ctrl.exceptions import SolverError
from pilegrasp_ctrl.provenance import SOLVER_PACKAGES, version_of
from pilegrasp_ctrl.qp.problem import as_problem
from pilegrasp_ctrl.qp.program import FEASIBILITY, QuadraticProgram, Solver, make_solver, solve
from pilegrasp_ctrl.statistics import markdown_table
from pilegrasp_ctrl.types import Array
from pilegrasp_ctrl.validation.bench.clock import Timing, Work, garbage_kept, time_in_turns
from recorded_program import RecordedProgram, load_programs
from script import run_script

RECORDED = Path(__file__).resolve().parents[2] / "tests" / "data" / "qp_programs.npy"
"""File of the programs by default."""

NAIVE = ("osqp", "proxqp")
"""Solvers that are also called through qpsolvers with default settings."""

REFERENCE = "daqp"
"""Solver whose time is the unit of the others."""

GROUPS = ("free", "bound", "infeasible")
"""Groups of programs: without an active bound at the optimum, with one, and without a feasible point."""

ACCURACY = 1e-6
"""Largest error of a right answer, relative to the largest entry of the optimum [-]; chosen."""

REPETITIONS = 3
"""Number of further solutions of all programs that are compared to the bit [-]; chosen."""


class Verdict(NamedTuple):
    """Counts of the answers to programs of one kind.

    Attributes:
        right: Number of programs solved to `ACCURACY` within all bounds or, without a solution, refused.
        refused: Number of other programs that were refused.
        wrong: Number of other answers.
        error: Largest error of an answer, wrong ones included [rad/s²].
    """

    right: int = 0
    refused: int = 0
    wrong: int = 0
    error: float = 0.0

    def with_one(self, field: str, error: float) -> Verdict:
        """Return the verdict with one more answer: "right", "refused" or "wrong"."""
        return self._replace(**{field: getattr(self, field) + 1, "error": max(self.error, error)})


class SolverAssessment(NamedTuple):
    """The answers of one solver to all programs.

    Attributes:
        verdicts: Verdicts by kind of program; "softened" are the infeasible ones with soft bounds on x.
        torque_error: Largest error of G x, wrong answers included [N·m].
        excess: Largest amount by which an answer leaves the bounds on x [rad/s²].
        torque_excess: Largest amount by which an answer leaves the bounds on G x [N·m].
        repeatable: Whether another instance gives the same bits for the same programs in another order.
    """

    verdicts: dict[str, Verdict]
    torque_error: float
    excess: float
    torque_excess: float
    repeatable: bool

    @classmethod
    def of(cls, make: Callable[[], Solver], programs: Sequence[RecordedProgram]) -> SolverAssessment:
        """Assess a new solver on every program, and on the softened form of every infeasible program."""
        cases = [(program.kind, program.problem, program, not program.feasible) for program in programs]
        cases += [("softened", problem.softened(), program, False) for _, problem, program, refuse in cases if refuse]
        solver = make()
        answers = [solver.solve(problem) for _, problem, _, _ in cases]
        errors, verdicts = np.zeros((len(cases), 4)), {kind: Verdict() for kind, *_ in cases}
        for row, (x, (kind, _, program, refuse)) in enumerate(zip(answers, cases, strict=True)):
            right = x is None if refuse else x is not None
            if x is not None and not refuse:
                errors[row] = _errors(program, x)
                right = errors[row, 0] <= ACCURACY * np.abs(program.x).max() and errors[row, 2:].max() <= FEASIBILITY
            outcome = "right" if right else "refused" if x is None else "wrong"
            verdicts[kind] = verdicts[kind].with_one(outcome, errors[row, 0])
        _, torque_error, excess, torque_excess = errors.max(axis=0).tolist()
        repeatable = _repeats(make, [problem for _, problem, _, _ in cases], answers)
        return cls(verdicts, torque_error, excess, torque_excess, repeatable)


def _errors(program: RecordedProgram, x: Array) -> tuple[float, float, float, float]:
    """Return the errors of x and of G x, and the excess of each over its bounds; soft bounds have no excess."""
    _, _, G, lower, upper = program.problem
    n = len(program.x)
    x = x[:n]
    error = x - program.x
    values = np.concatenate((x, G @ x))
    excess = np.maximum(np.maximum(lower - values, values - upper), 0.0)
    if not program.feasible:
        excess[:n] = 0.0
    return (
        float(np.abs(error).max()),
        float(np.abs(G @ error).max()),
        float(excess[:n].max()),
        float(excess[n:].max()),
    )


def _repeats(make: Callable[[], Solver], problems: Sequence[QuadraticProgram], answers: Sequence[Array | None]) -> bool:
    """Return whether another instance gives the same bits for copies of the problems in several other orders.

    The copies and the kept arrays move the solver's own memory, because the alignment matters for vectorised sums.
    """
    rng = np.random.default_rng(0)
    kept = []
    for _ in range(REPETITIONS):
        kept += [np.zeros(size) for size in rng.integers(1, 64, 200)]
        solver = make()
        for row in rng.permutation(len(problems)):
            x, first = solver.solve(QuadraticProgram(*(array.copy() for array in problems[row]))), answers[row]
            if (x is None) != (first is None) or (x is not None and not np.array_equal(x, first)):
                return False
    return True


class NaiveSolver:
    """One call of `qpsolvers.solve_qp` with default settings, which trusts the package's tolerances and status.

    Attributes:
        name: Name of the package, after "naive".
    """

    def __init__(self, package: str) -> None:
        """Choose one of `qpsolvers.available_solvers`."""
        self.name = f"naive {package}"
        self._package = package

    def solve(self, program: QuadraticProgram) -> Array | None:
        """Return x (n,), or None if the package finds no solution."""
        solution = qpsolvers.solve_problem(as_problem(program), self._package)
        return solution.x if solution.found else None


class SolverRow(NamedTuple):
    """One solver.

    Attributes:
        solver: Name of the solver.
        version: Version of its package.
        assessment: Answers of the solver to the programs.
        timings: Timings of the solver alone by group of programs; for infeasible ones, of both attempts together.
    """

    solver: str
    version: str
    assessment: SolverAssessment
    timings: dict[str, Timing]


class SolverComparison(NamedTuple):
    """All installed solvers, in the order in which they are printed."""

    rows: tuple[SolverRow, ...]

    @classmethod
    def of(cls, programs: Sequence[RecordedProgram], blocks: int = 20, block_time: float = 0.02) -> SolverComparison:
        """Assess and time every solver; the timings take turns, so that other programs disturb all of them alike.

        Args:
            programs: Programs, at least one of every group of `GROUPS`.
            blocks: Number of blocks of calls for each solver and group.
            block_time: Time that a block should take [s].
        """
        makers = _makers()
        with warnings.catch_warnings():
            # qpsolvers warns of the matrices in every naive call.
            warnings.simplefilter("ignore")
            assessments = {name: SolverAssessment.of(make, programs) for name, make in makers.items()}
            works = [
                Work(f"{name}/{group}", _work(make(), group, programs))
                for group in GROUPS
                for name, make in makers.items()
            ]
            with garbage_kept():
                timings = time_in_turns(works, blocks, block_time)
        rows = []
        for name, assessment in assessments.items():
            package = name.removeprefix("naive ")
            own = {group: timings[f"{name}/{group}"] for group in GROUPS}
            rows.append(SolverRow(name, version_of(SOLVER_PACKAGES[package][0][0]), assessment, own))
        return cls(tuple(rows))

    def markdown(self) -> str:
        """Return two tables: accuracy and speed, then right / refused / wrong and largest error by kind of program."""
        (reference,) = (row.timings for row in self.rows if row.solver == REFERENCE)
        head = ("solver", "version", "error [N·m]", "excess [rad/s²]", "excess [N·m]", "same bits")
        times = [f"{group}: median / p99 [µs] / × {REFERENCE}" for group in GROUPS]
        first = []
        for row in self.rows:
            _, *figures, repeatable = row.assessment
            cells = (row.solver, row.version, *(f"{figure:.0e}" for figure in figures), "yes" if repeatable else "no")
            first.append((*cells, *(_time(row.timings[group], reference[group]) for group in GROUPS)))
        second = []
        for kind in self.rows[0].assessment.verdicts:
            verdicts = (row.assessment.verdicts[kind] for row in self.rows)
            second.append((kind, *(_verdict(verdict) for verdict in verdicts)))
        solvers = ("kind: right / refused / wrong, error [rad/s²]", *(row.solver for row in self.rows))
        return f"{markdown_table((*head, *times), first)}\n\n{markdown_table(solvers, second)}"


def _makers() -> dict[str, Callable[[], Solver]]:
    """Return the maker of each solver whose package is installed."""
    names = dict.fromkeys((REFERENCE, "osqp", *qpsolvers.available_solvers))
    makers: dict[str, Callable[[], Solver]] = {name: partial(make_solver, name) for name in names}
    return makers | {f"naive {name}": partial(NaiveSolver, name) for name in NAIVE if name in makers}


def _work(solver: Solver, group: str, programs: Sequence[RecordedProgram]) -> Callable[[int], object]:
    """Return work that solves the programs of a group one after the other."""
    problems = [program.problem for program in programs if _group(program) == group]
    if group != "infeasible":
        return lambda index: solver.solve(problems[index % len(problems)])

    def both(index: int) -> object:
        try:
            return solve(problems[index % len(problems)], solver)
        except SolverError:
            return None

    return both


def _group(program: RecordedProgram) -> str:
    if not program.feasible:
        return "infeasible"
    return "bound" if program.multipliers.any() else "free"


def _time(timing: Timing, reference: Timing) -> str:
    return f"{1e6 * timing.median:.0f} / {1e6 * timing.p99:.0f} / {timing.median / reference.median:.1f}"


def _verdict(verdict: Verdict) -> str:
    *counts, error = verdict
    return f"{' / '.join(map(str, counts))}, {error:.0e}"


def main(file: Path = RECORDED) -> None:
    """Compare the solvers on the programs of FILE and print two tables."""
    print(SolverComparison.of(load_programs(file)).markdown())


if __name__ == "__main__":
    run_script(main)
