"""Every solver on the same recorded programs: what it makes of them, and how long it takes."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from functools import partial
from importlib.metadata import version
from typing import NamedTuple

from naive_solver import NaiveSolver
from pilegrasp_ctrl.exceptions import ConfigurationError, SolverError
from pilegrasp_ctrl.qp.program import SOLVERS, Solver, make_solver, solve
from pilegrasp_ctrl.statistics import markdown_table
from pilegrasp_ctrl.validation.bench.clock import Timing, Work, garbage_kept, time_in_turns
from recorded_program import RecordedProgram
from solver_assessment import SolverAssessment, Verdict

PACKAGES = {"proxqp": "proxsuite"}
"""Packages that are not called as their solver is."""

NAIVE = ("osqp", "proxqp")

REFERENCE = "daqp"

GROUPS = ("free", "bound", "infeasible")
"""Programs in whose optimum no bound is active, those in which one is, and those that have to be softened."""


class SolverRow(NamedTuple):
    """One solver.

    Attributes:
        solver: its name.
        version: of its package.
        assessment: what it made of the programs.
        timings: by group of programs, of the solver alone; for infeasible ones, of both attempts together.
    """

    solver: str
    version: str
    assessment: SolverAssessment
    timings: dict[str, Timing]


class SolverComparison(NamedTuple):
    """All solvers that are installed, in the order in which they are printed."""

    rows: tuple[SolverRow, ...]

    @classmethod
    def of(cls, programs: Sequence[RecordedProgram], blocks: int = 20, block_time: float = 0.02) -> SolverComparison:
        """Assess and time every solver; the timings are taken in turns, so that their ratios can be believed.

        Args:
            programs: what to solve, at least one of every group of `GROUPS`.
            blocks: number of blocks of calls for each solver and group.
            block_time: what a block should take [s].
        """
        makers = _makers()
        with warnings.catch_warnings():
            # The naive calls are warned about their matrices in every call.
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
            rows.append(SolverRow(name, version(PACKAGES.get(package, package)), assessment, own))
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
    """Return how to make each solver whose package is installed."""
    makers: dict[str, Callable[[], Solver]] = {}
    for name in SOLVERS:
        try:
            make_solver(name)
        except ConfigurationError:
            continue
        makers[name] = partial(make_solver, name)
    return makers | {f"naive {name}": partial(NaiveSolver, name) for name in NAIVE if name in makers}


def _work(solver: Solver, group: str, programs: Sequence[RecordedProgram]) -> Callable[[int], object]:
    """Return what solves the programs of a group one after the other."""
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
