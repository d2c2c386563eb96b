"""What a solver makes of programs whose optima are known."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from pilegrasp_ctrl.qp.program import FEASIBILITY, QuadraticProgram, Solver
from pilegrasp_ctrl.types import Array
from recorded_program import RecordedProgram

ACCURACY = 1e-6
"""Largest error of a right answer, relative to the largest entry of the optimum."""

REPETITIONS = 3
"""How often all programs are solved again to see whether the answers are the same bits."""


class Verdict(NamedTuple):
    """How the programs of one kind went.

    Attributes:
        right: how many were solved to `ACCURACY` within all bounds or, where there is no solution, refused.
        refused: how many others were refused.
        wrong: how many were answered otherwise.
        error: largest error of an answer, wrong ones included [rad/s²].
    """

    right: int = 0
    refused: int = 0
    wrong: int = 0
    error: float = 0.0

    def with_one(self, field: str, error: float) -> Verdict:
        """Return the verdict with one more that is "right", "refused" or "wrong"."""
        return self._replace(**{field: getattr(self, field) + 1, "error": max(self.error, error)})


class SolverAssessment(NamedTuple):
    """What one solver made of all programs.

    Attributes:
        verdicts: by kind of program; "softened" are the infeasible ones with soft bounds on x.
        torque_error: largest error of G x, wrong answers included [N·m].
        excess: by how much an answer leaves the bounds on x [rad/s²].
        torque_excess: by how much one leaves those on G x [N·m].
        repeatable: whether the same programs in another order, by another instance, gave the same bits.
    """

    verdicts: dict[str, Verdict]
    torque_error: float
    excess: float
    torque_excess: float
    repeatable: bool

    @classmethod
    def of(cls, make: Callable[[], Solver], programs: Sequence[RecordedProgram]) -> SolverAssessment:
        """Let a new solver solve every program, and where it is infeasible the softened one too."""
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
    """Return the errors of x and of G x, and by how much each leaves its bounds; soft ones are meant to be left."""
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

    The copies and the arrays that are kept move the solver's own memory: where sums are vectorised, alignment matters.
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
