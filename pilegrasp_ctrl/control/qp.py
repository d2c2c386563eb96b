"""The quadratic program of one control period, and what counts as its solution."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from ..exceptions import ConfigurationError, SolverError
from ..types import Array

SOLVERS = ("daqp", "osqp")

FEASIBILITY = 1e-6
"""Largest violation of a row that is still a solution, relative to 1 + the size of its bound."""


class QuadraticProgram(NamedTuple):
    """Minimise ½ xᵀ H x + fᵀ x under two-sided bounds on x and on G x.

    Attributes:
        H: (n, n) symmetric positive definite.
        f: (n,).
        G: (m, n).
        lower: (n + m,) of x, then of G x; -inf where there is none.
        upper: (n + m,).
    """

    H: Array
    f: Array
    G: Array
    lower: Array
    upper: Array

    @classmethod
    def empty(cls, n: int, m: int) -> QuadraticProgram:
        """Allocate a program of n variables and m rows, for filling in place each period."""
        return cls(np.zeros((n, n)), np.zeros(n), np.zeros((m, n)), np.full(n + m, -np.inf), np.full(n + m, np.inf))


class Solver(Protocol):
    """Proposes a solution; `solve` below decides whether it is one."""

    name: str

    def solve(self, problem: QuadraticProgram, soft: bool) -> Array | None:
        """Return x (n,), or None where the solver found none.

        With `soft`, the bounds on x itself may be exceeded at a high cost and only the rows of G are hard.
        """


class Solution(NamedTuple):
    """A solution whose residuals were computed from the problem.

    Attributes:
        x: (n,).
        Gx: (m,).
        slack: (2, n + m) distances to the lower and to the upper bounds; negative where a bound is exceeded.
        relaxed: whether the bounds on x had to be softened.
    """

    x: Array
    Gx: Array
    slack: Array
    relaxed: bool


def solve(problem: QuadraticProgram, solver: Solver) -> Solution:
    """Solve with hard bounds and, where they contradict the rows of G, with soft ones.

    A solver's status is never trusted: the bounds are evaluated at its answer.

    Raises:
        SolverError: where the problem holds a value that is not finite, or no answer satisfies the rows of G.
    """
    n = problem.f.shape[0]
    for soft in (False, True):
        x = solver.solve(problem, soft)
        if x is None:
            continue
        values = np.empty(problem.lower.shape)
        values[:n] = x
        Gx = values[n:]
        np.dot(problem.G, x, out=Gx)
        slack = np.empty((2, values.shape[0]))
        np.subtract(values, problem.lower, out=slack[0])
        np.subtract(problem.upper, values, out=slack[1])
        hard = slack[:, n:] if soft else slack
        # The second comparison is reached only where a bound is nearly active; a NaN fails both.
        if np.minimum.reduce(hard, axis=None) >= 0.0 or _feasible(problem, hard, n if soft else 0):
            return Solution(x, Gx, slack, soft)
    _check_finite(problem)
    raise SolverError(f"{solver.name} found no accelerations within the torque limits")


def make_solver(name: str, n: int, m: int) -> Solver:
    """Return the solver called "daqp" or "osqp" for programs of n variables and m rows.

    Raises:
        ConfigurationError: where the name is neither.
    """
    if name == "daqp":
        from .daqp_solver import DaqpSolver  # noqa: PLC0415

        return DaqpSolver(n, m)
    if name == "osqp":
        from .osqp_solver import OsqpSolver  # noqa: PLC0415

        return OsqpSolver(n, m)
    raise ConfigurationError(f"no solver {name!r}; the solvers are {', '.join(SOLVERS)}")


def _feasible(problem: QuadraticProgram, slack: Array, first: int) -> bool:
    bounds = np.stack((problem.lower[first:], problem.upper[first:]))
    size = np.where(np.isfinite(bounds), np.abs(bounds), 0.0)
    return bool((slack >= -FEASIBILITY * (1.0 + size)).all())


def _check_finite(problem: QuadraticProgram) -> None:
    for name, array in zip("HfG", problem[:3], strict=True):
        if not np.isfinite(array).all():
            raise SolverError(f"the quadratic program's {name} holds a value that is not finite")
    if np.isnan(problem.lower).any() or np.isnan(problem.upper).any():
        raise SolverError("the quadratic program's bounds hold a value that is not a number")
