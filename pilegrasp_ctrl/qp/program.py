"""The quadratic program of one control period, the check of its solution, and the solvers by name."""

from __future__ import annotations

from importlib import import_module
from typing import NamedTuple, Protocol

import numpy as np

from ..exceptions import ConfigurationError, SolverError
from ..types import Array

SOLVERS = ("daqp", "osqp", "proxqp", "quadprog")
"""Names of the solvers; the last two need optional packages."""

FEASIBILITY = 1e-5
"""Largest violation of a bound by an answer that still counts as a solution [rad/s², N·m]; chosen."""

SOFT_WEIGHT = 1e4
"""Cost of exceeding a softened bound, against the tool's weight of 1; chosen.

The farthest target asks for about 1000 m/s². At this cost it exceeds a bound by 0.1 rad/s². That is 0.4 mrad/s at the
end of the limits' horizon, less than their margin. A cost of 100 drives a joint outside its range farther outwards.
"""


class QuadraticProgram(NamedTuple):
    """Minimise ½ xᵀ H x + fᵀ x under two-sided bounds on x and on G x.

    Attributes:
        H: (n, n) Symmetric positive definite matrix of the cost.
        f: (n,) Linear part of the cost.
        G: (m, n) Rows of the constraints.
        lower: (n + m,) Lower bounds of x, then of G x; -inf where there is none.
        upper: (n + m,) Upper bounds of x, then of G x; inf where there is none.
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
    """A solver that proposes a solution; the function `solve` checks it.

    Attributes:
        name: Name of the solver, for error messages.
    """

    name: str

    def solve(self, problem: QuadraticProgram) -> Array | None:
        """Return x (n,), or None if the solver found none."""


class Solution(NamedTuple):
    """A solution whose residuals were computed from the problem.

    Attributes:
        x: (n,) Solution.
        slack: (2, n + m) Distances to the lower and to the upper bounds; negative for an exceeded bound.
        margin: Smallest of these distances.
        relaxed: Whether the bounds on x had to be softened.
    """

    x: Array
    slack: Array
    margin: float
    relaxed: bool


def solve(problem: QuadraticProgram, solver: Solver) -> Solution:
    """Return the solution with hard bounds or, if the bounds on x contradict those on G x, with soft bounds on x.

    The solver's status is not used: the bounds are evaluated at its answer.

    Raises:
        SolverError: The problem has a value that is not finite, or no answer satisfies the bounds on G x.
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
        values[n:] = problem.G.dot(x)
        slack = np.empty((2, len(values)))
        np.subtract(values, problem.lower, out=slack[0])
        np.subtract(problem.upper, values, out=slack[1])
        # argmin costs a fifth of min. It finds a NaN first, which fails the comparison.
        margin = slack.item(slack.argmin())
        if (float(slack[:, n:].min()) if relaxed else margin) >= -FEASIBILITY:
            return Solution(x, slack, margin, relaxed)
    raise SolverError(f"{solver.name} found no accelerations within the torque limits")


def make_solver(name: str) -> Solver:
    """Return the solver `name`, one of `SOLVERS`.

    Raises:
        ConfigurationError: The solver is unknown, or its package is not installed.
    """
    if name not in SOLVERS:
        raise ConfigurationError(f"no solver {name!r}; the solvers are {', '.join(SOLVERS)}")
    # Each package takes 0.1 to 0.5 s to load, and two of them are optional.
    module = import_module(f".{name}_solver", __package__)
    solver: Solver = getattr(module, f"{name.capitalize()}Solver")()
    return solver


def _check_finite(problem: QuadraticProgram) -> None:
    for name, array in (("H", problem.H), ("f", problem.f), ("G", problem.G)):
        if not np.isfinite(array).all():
            raise SolverError(f"the quadratic program's {name} holds a value that is not finite")
    if np.isnan(problem.lower).any() or np.isnan(problem.upper).any():
        raise SolverError("the quadratic program's bounds hold a NaN")
