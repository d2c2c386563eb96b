"""Any solver of qpsolvers: it finds the active bounds, and an exact method completes its answer."""

from __future__ import annotations

from typing import Any

import numpy as np
import qpsolvers
from scipy.sparse import csc_matrix

from ..exceptions import ConfigurationError
from ..types import Array
from ..vectors import rotated
from .least_distance import LeastDistanceProgram
from .problem import RowKinds, as_problem
from .program import QuadraticProgram
from .quiet import without_warnings
from .solvers import described, refused_name

_NEAR = 1e-4
"""Distance to a bound below which it counts as active, where a solver gives no multipliers, relative to y; chosen."""


class QpsolversSolver:
    """Calls a solver of qpsolvers, and completes its answer.

    The solver gets the program as a least distance: the cost is a sphere and every row has unit length. The distance is
    scaled to about 1, because the solvers' tolerances are absolute. The solver's multipliers, or the bounds near its
    answer, are the guess of the active bounds from which `LeastDistanceProgram.nearest` finds the exact optimum. So the
    tolerances have no influence on the answer.

    Attributes:
        name: Name of the solver, one of `qpsolvers.available_solvers`.
        settings: Settings of the solver, such as `max_iter=50`; each solver has its own.
    """

    reads_only = True

    def __init__(self, name: str, **settings: Any) -> None:
        """Choose a solver and its settings, and try them on a small program.

        Raises:
            ConfigurationError: qpsolvers does not know the solver, its package is not installed, or the solver fails,
                as with a setting that it does not know or without a licence.
        """
        if name not in qpsolvers.available_solvers:
            raise refused_name(name, qpsolvers.available_solvers)
        self.name = name
        self.settings = settings
        one = np.ones((1, 1))
        try:
            self._solution(QuadraticProgram(one, -one[0], one, np.full(2, -np.inf), np.array([np.inf, 0.5])))
        except Exception as error:
            raise ConfigurationError(f"{self} fails on a small program: {described(error)}") from error

    def __repr__(self) -> str:
        settings = "".join(f", {key}={value!r}" for key, value in self.settings.items())
        return f"QpsolversSolver({self.name!r}{settings})"

    def solve(self, program: QuadraticProgram) -> Array | None:
        """Return x (n,), or None if there is none."""
        distance = LeastDistanceProgram.from_program(program)
        if distance is None:
            return None
        y = distance.nearest(self._guess(distance))
        return None if y is None else distance.x(y)

    def _guess(self, distance: LeastDistanceProgram) -> Array:
        """Return the sides (k,) on which bounds are active by the solver's answer, converged or not."""
        k, n = distance.rows.shape
        if not k:
            return np.zeros(0)
        unit = max(1.0, float(np.abs(distance.goal).max()))
        free = np.full(n, np.inf)
        lower, upper = np.concatenate((-free, distance.lower / unit)), np.concatenate((free, distance.upper / unit))
        scaled = QuadraticProgram(np.eye(n), -distance.goal / unit, distance.rows, lower, upper)
        try:
            solution = self._solution(scaled)
        except qpsolvers.exceptions.SolverError:  # cvxopt raises it for some programs without a solution
            return np.zeros(k)
        return _sides(solution, RowKinds.of(scaled), n + k)[n:]

    def _solution(self, program: QuadraticProgram) -> qpsolvers.Solution:
        problem = as_problem(program)
        if self.name not in qpsolvers.dense_solvers:
            problem.P, problem.G, problem.A = (
                None if matrix is None else csc_matrix(matrix) for matrix in (problem.P, problem.G, problem.A)
            )
        with without_warnings():
            return qpsolvers.solve_problem(problem, self.name, **self.settings)


def _sides(solution: qpsolvers.Solution, kinds: RowKinds, rows: int) -> Array:
    """Return 1 for each active lower bound, -1 for each active upper one, otherwise 0 (rows,).

    A bound is active if its multiplier is larger than the distance to it, both being about 1 or about 0.
    """
    sides, problem = np.zeros(rows), solution.problem
    if solution.x is None:
        return sides
    if len(kinds.equal):
        # A side that is wrong is changed by the exact method.
        sides[kinds.equal] = 1.0 if _size(solution.y) != len(kinds.equal) else -np.sign(solution.y)
    if problem.G is not None:
        G = problem.G.toarray() if isinstance(problem.G, csc_matrix) else problem.G
        distance = problem.h - rotated(G, solution.x)
        given = _size(solution.z) == len(distance)
        active = distance < (np.asarray(solution.z, dtype=float) if given else _NEAR)
        above = len(kinds.above)
        sides[kinds.above] -= active[:above]
        sides[kinds.below] += active[above:]
    return sides


def _size(multipliers: Array | None) -> int:
    return -1 if multipliers is None else int(np.size(multipliers))
