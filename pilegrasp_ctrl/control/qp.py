"""The quadratic program of one control period, and what counts as its solution."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from ..exceptions import ConfigurationError, SolverError
from ..types import Array

SOLVERS = ("daqp", "osqp")

FEASIBILITY = 1e-5
"""Largest violation of a bound by an answer that still is a solution [rad/s², N·m]."""

SOFT_WEIGHT = 1e2
"""Cost of exceeding a softened bound, against the tool's weight of 1.

A wish of 50 m/s² buys 0.5 rad/s², 2 mrad/s at the end of the limits' horizon: less than their margin.
"""


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

    def softened(self) -> QuadraticProgram:
        """Return the program in (x, s) whose bounds on x may be exceeded by s at the cost `½ SOFT_WEIGHT |s|²`.

        The bounds on G x stay as they are.
        """
        n, m = len(self.f), len(self.G)
        identity, zero = np.eye(n), np.zeros((n, n))
        H = np.block([[self.H, zero], [zero, SOFT_WEIGHT * identity]])
        G = np.block([[identity, identity], [self.G, np.zeros((m, n))]])
        free = np.full(2 * n, np.inf)
        lower, upper = np.concatenate((-free, self.lower)), np.concatenate((free, self.upper))
        return QuadraticProgram(H, np.concatenate((self.f, np.zeros(n))), G, lower, upper)


class Solver(Protocol):
    """Proposes a solution; `solve` below decides whether it is one.

    Attributes:
        name: how errors call it.
    """

    name: str

    def solve(self, problem: QuadraticProgram) -> Array | None:
        """Return x (n,), or None where the solver found none."""


class Solution(NamedTuple):
    """A solution whose residuals were computed from the problem.

    Attributes:
        x: (n,).
        Gx: (m,).
        slack: (2, n + m) distances to the lower and to the upper bounds; negative where a bound is exceeded.
        margin: the smallest of them.
        relaxed: whether the bounds on x had to be softened.
    """

    x: Array
    Gx: Array
    slack: Array
    margin: float
    relaxed: bool


def solve(problem: QuadraticProgram, solver: Solver) -> Solution:
    """Solve with hard bounds and, where those on x contradict those on G x, with soft bounds on x.

    A solver's status is never trusted: the bounds are evaluated at its answer.

    Raises:
        SolverError: where the problem holds a value that is not finite, or no answer satisfies the bounds on G x.
    """
    n = len(problem.f)
    for relaxed in (False, True):
        if relaxed:
            _check_finite(problem)
        x = solver.solve(problem.softened() if relaxed else problem)
        if x is None:
            continue
        x = x[:n]
        values = np.empty(len(problem.lower))
        values[:n] = x
        Gx = values[n:]
        np.dot(problem.G, x, out=Gx)
        slack = np.empty((2, len(values)))
        np.subtract(values, problem.lower, out=slack[0])
        np.subtract(problem.upper, values, out=slack[1])
        margin = float(np.minimum.reduce(slack, axis=None))
        # A NaN fails the comparison.
        if (float(slack[:, n:].min()) if relaxed else margin) >= -FEASIBILITY:
            return Solution(x, Gx, slack, margin, relaxed)
    raise SolverError(f"{solver.name} found no accelerations within the torque limits")


def make_solver(name: str) -> Solver:
    """Return the solver called "daqp" or "osqp".

    Raises:
        ConfigurationError: where the name is neither.
    """
    if name == "daqp":
        from .daqp_solver import DaqpSolver

        return DaqpSolver()
    if name == "osqp":
        from .osqp_solver import OsqpSolver

        return OsqpSolver()
    raise ConfigurationError(f"no solver {name!r}; the solvers are {', '.join(SOLVERS)}")


def _check_finite(problem: QuadraticProgram) -> None:
    for name, array in (("H", problem.H), ("f", problem.f), ("G", problem.G)):
        if not np.isfinite(array).all():
            raise SolverError(f"the quadratic program's {name} holds a value that is not finite")
    if np.isnan(problem.lower).any() or np.isnan(problem.upper).any():
        raise SolverError("the quadratic program's bounds hold a value that is not a number")
