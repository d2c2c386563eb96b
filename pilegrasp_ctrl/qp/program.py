"""The quadratic program of one control period, and the check of its solution."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..exceptions import ArgumentError, SolverError, environment_fault
from ..kernels.program import write_slack
from ..types import Array
from .solvers import Solver as Solver
from .solvers import described, solver_name
from .solvers import make_solver as make_solver

FEASIBILITY = 1e-5
"""Largest violation of a bound by an answer that still counts as a solution [rad/s², N·m]; chosen."""

SOFT_WEIGHT = 1e4
"""Cost of exceeding a softened bound, against the tool's weight of 1; chosen.

The farthest target asks for about 1000 m/s². At this cost it exceeds a bound by 0.1 rad/s². That is 0.4 mrad/s at the
end of the limits' horizon, less than their margin. A cost of 100 drives a joint outside its range farther outwards.
"""


class QuadraticProgram(NamedTuple):
    """Minimise ½ xᵀ H x + fᵀ x under two-sided bounds on the n + m rows x and G x.

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

    def softened(self, soft: NDArray[np.bool_] | None = None, weight: float = SOFT_WEIGHT) -> QuadraticProgram:
        """Return the program in (x, s) whose soft bounds may be exceeded by s (k,) at the cost `½ weight |s|²`.

        The k rows that are soft and have a finite bound get an entry of s each, in their order. All rows of this
        program become the last n + m rows of the new one: `lower <= r + s <= upper` for a soft row r, `lower <= r <=
        upper` for a hard one. There are no bounds on (x, s) itself.

        Args:
            soft: (n + m,) Whether each row is soft; the bounds on x if absent.
            weight: Cost of exceeding a soft bound.

        Raises:
            ArgumentError: `soft` has another shape, or `weight` is not a positive number.
        """
        n, rows = len(self.f), len(self.lower)
        soft = _checked_softening(self, soft, weight)
        slackened = np.flatnonzero(soft & (np.isfinite(self.lower) | np.isfinite(self.upper)))
        size = n + len(slackened)
        H, G, f = np.zeros((size, size)), np.zeros((rows, size)), np.zeros(size)
        H[:n, :n], H[range(n, size), range(n, size)] = self.H, weight
        G[range(n), range(n)], G[n:, :n] = 1.0, self.G
        G[slackened, range(n, size)] = 1.0
        f[:n] = self.f
        free = np.full(size, np.inf)
        return QuadraticProgram(H, f, G, np.concatenate((-free, self.lower)), np.concatenate((free, self.upper)))


class Solution(NamedTuple):
    """A solution whose residuals were computed from the program.

    Attributes:
        x: (n,) Solution.
        slack: (2, n + m) Distances to the lower and to the upper bounds; negative for an exceeded bound.
        margin: Smallest of these distances.
        relaxed: Whether the soft bounds had to be relaxed.
        soft: (n + m,) Whether each row is soft; None if only the bounds on x are.
        soft_weight: Cost of exceeding a soft bound.
    """

    x: Array
    slack: Array
    margin: float
    relaxed: bool
    soft: NDArray[np.bool_] | None = None
    soft_weight: float = SOFT_WEIGHT


def solve(
    program: QuadraticProgram,
    solver: Solver,
    soft: NDArray[np.bool_] | None = None,
    soft_weight: float = SOFT_WEIGHT,
) -> Solution:
    """Return the solution within all bounds or, if there is none, the one within the hard bounds.

    The second one exceeds the soft bounds by the least amount in least squares, see `QuadraticProgram.softened`. The
    solver's status is not used: the bounds are evaluated at its answer.

    Args:
        program: Program to solve.
        solver: Solver to use, such as `make_solver("daqp")`.
        soft: (n + m,) Whether each row is soft; the bounds on x if absent.
        soft_weight: Cost of exceeding a soft bound.

    Raises:
        SolverError: The program has a value that is not finite, no answer satisfies the hard bounds, or the solver
            raised an error or returned something else than an answer.
        ArgumentError: The arrays of the program do not fit together, or `soft` or `soft_weight` cannot be used.
    """
    _check_shapes(program)
    if soft is not None or soft_weight != SOFT_WEIGHT:
        soft = _checked_softening(program, soft, soft_weight)
    n = len(program.f)
    x, reason = _answer(solver, program)
    if x is not None:
        slack = np.empty((2, len(program.lower)))
        margin = write_slack(x, program.G, program.lower, program.upper, slack)
        if margin >= -FEASIBILITY:
            return Solution(x, slack, margin, False, soft, soft_weight)
    _check_values(program)
    x, reason = _answer(solver, program.softened(soft, soft_weight))
    if x is not None:
        x, slack = x[:n].copy(), np.empty((2, len(program.lower)))
        margin = write_slack(x, program.G, program.lower, program.upper, slack)
        hard = slack[:, n:] if soft is None else slack[:, ~soft]
        if hard.min(initial=np.inf) >= -FEASIBILITY and np.isfinite(x).all():
            return Solution(x, slack, margin, True, soft, soft_weight)
    raise SolverError(reason or f"{solver_name(solver)} found no accelerations within the hard limits")


def _answer(solver: Solver, program: QuadraticProgram) -> tuple[Array | None, str]:
    """Return the answer (n,) of a solver, or None and the reason if that is a fault of the solver.

    What the environment refuses a solver is no answer to a program, so another program is not tried.

    A solver may overwrite what it is given and return the same array again, so it gets copies and is copied from. The
    library's own solvers do neither.

    Raises:
        SolverError: The environment has refused the solver something, such as memory.
    """
    reads_only = getattr(solver, "reads_only", False)
    try:
        x = solver.solve(program if reads_only else QuadraticProgram(*(array.copy() for array in program)))
    except Exception as error:
        reason = f"{solver_name(solver)} raised {described(error)}"
        if environment_fault(error):
            raise SolverError(reason) from error
        return None, reason
    if x is None or (reads_only and isinstance(x, np.ndarray) and x.dtype == float and x.shape == program.f.shape):
        return x, ""
    expected = f"it must return an array of shape ({len(program.f)},) or None"
    if not isinstance(x, np.ndarray):
        return None, f"{solver_name(solver)} returned a {type(x).__name__}; {expected}"
    if x.dtype.kind not in "fiu":
        return None, f"{solver_name(solver)} returned an array of {x.dtype}; {expected}"
    if x.shape != program.f.shape:
        return None, f"{solver_name(solver)} returned an array of shape {x.shape}; {expected}"
    return np.array(x, dtype=float), ""


def _checked_softening(program: QuadraticProgram, soft: NDArray[np.bool_] | None, weight: float) -> NDArray[np.bool_]:
    """Return which rows are soft (n + m,); refuse a mask that does not fit and a weight that is not positive."""
    rows = len(program.lower)
    if not 0.0 < weight < np.inf:
        raise ArgumentError(f"soft_weight = {weight} must be a positive number")
    if soft is None:
        return np.arange(rows) < len(program.f)
    if np.shape(soft) != (rows,) or np.asarray(soft).dtype != bool:
        raise ArgumentError(f"soft must be {rows} booleans, one for each row; it has the shape {np.shape(soft)}")
    return np.asarray(soft)


def _check_shapes(program: QuadraticProgram) -> None:
    H, f, G, lower, upper = program
    n, m = len(f), len(G)
    if H.shape != (n, n) or G.shape != (m, n) or len(lower) != n + m or len(upper) != n + m:
        shapes = ", ".join(f"{name} {array.shape}" for name, array in program._asdict().items())
        raise ArgumentError(f"the quadratic program's arrays do not fit together: {shapes}")


def _check_values(program: QuadraticProgram) -> None:
    for name, array in (("H", program.H), ("f", program.f), ("G", program.G)):
        if not np.isfinite(array).all():
            raise SolverError(f"the quadratic program's {name} holds a value that is not finite")
    if not (program.lower < np.inf).all() or not (program.upper > -np.inf).all():
        raise SolverError("the quadratic program's bounds hold a NaN or an infinity that no value can meet")
    if (crossed := program.lower > program.upper).any():
        raise SolverError(f"row {crossed.argmax()} of the quadratic program has a lower bound above its upper bound")
