"""The multipliers of a solution, computed from the program alone."""

from __future__ import annotations

import numpy as np
from scipy.optimize import nnls

from ..exceptions import SolverError
from ..types import Array
from ..vectors import rotated
from .program import FEASIBILITY, QuadraticProgram, Solution

_NNLS_ITERATIONS = 100
"""Largest number of iterations for each active bound [-]; chosen. Degenerate programs need more than scipy's 3."""


def multipliers(program: QuadraticProgram, solution: Solution) -> Array:
    """Return the multipliers (n + m,) of a solution, first of the bounds on x, then of those on G x.

    At an optimum `H x + f = multipliers[:n] + Gᵀ multipliers[n:]`. A multiplier is positive at an active lower bound,
    negative at an active upper one, and zero elsewhere. Its size is the rate at which the cost falls when the bound
    moves outwards. A bound is active within `FEASIBILITY`. For the active bounds, non-negative least squares finds the
    multipliers that meet the equation best, whatever solver found the answer. Where active bounds depend on each other,
    several multipliers meet it; one of them is returned.

    Of a relaxed solution, these are the multipliers of the softened program. They meet the same equation, and the
    multiplier of a soft row is its excess times the cost of exceeding it.

    Raises:
        SolverError: Non-negative least squares does not converge.
    """
    x, rows = solution.x, len(program.lower)
    if solution.relaxed:
        below, above = solution.slack
        softened = program.softened(solution.soft, solution.soft_weight)
        excess = np.maximum(-below, 0.0) - np.maximum(-above, 0.0)
        x = np.concatenate((x, excess[softened.G[:, len(x) :].any(axis=1)]))
        program = softened
    return _multipliers(program, x)[-rows:]


def _multipliers(program: QuadraticProgram, x: Array) -> Array:
    H, f, G, lower, upper = program
    rows = np.vstack((np.eye(len(f)), G))
    values = rotated(rows, x)
    active = np.concatenate((values - lower, upper - values)) <= FEASIBILITY
    normals = np.vstack((rows, -rows))[active]
    found = np.zeros(2 * len(rows))
    gradient = rotated(H, x) + f
    length, size = np.sqrt(np.einsum("ij,ij->i", normals, normals)), np.abs(gradient).max(initial=0.0)
    length[length == 0.0] = 1.0
    if len(normals) and size > 0.0:
        try:
            scaled, _ = nnls((normals / length[:, None]).T, gradient / size, maxiter=_NNLS_ITERATIONS * len(normals))
        except RuntimeError as error:
            raise SolverError(f"the multipliers of {len(normals)} active bounds were not found: {error}") from error
        found[active] = scaled * size / length
    return found[: len(rows)] - found[len(rows) :]
