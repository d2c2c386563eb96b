"""quadprog: the dual active-set method of Goldfarb and Idnani; an optional package under the GPL."""

from __future__ import annotations

import numpy as np

from ..exceptions import ConfigurationError
from ..types import Array
from .program import QuadraticProgram

try:
    import quadprog
except ImportError:
    raise ConfigurationError(
        "the solver 'quadprog' needs an optional package under the GPL: pip install 'pilegrasp[quadprog]'"
    ) from None


class QuadprogSolver:
    """Solves each program from scratch.

    quadprog takes one-sided rows and equations only. A two-sided row becomes two rows, and a row with equal bounds
    becomes an equation. Its tolerances are absolute, so it gets a cost of size 1 and rows of length 1. With a cost of
    size 1e6 its answers would be wrong.

    Attributes:
        name: "quadprog".
    """

    name = "quadprog"

    def solve(self, problem: QuadraticProgram) -> Array | None:
        """Return x (n,), or None if quadprog finds none."""
        H, f, G, lower, upper = problem
        # quadprog ignores rows with NaN.
        if not all(np.isfinite(array).all() for array in (H, f, G)) or not (lower <= upper).all():
            return None
        size = np.abs(H).max()
        rows = np.vstack((np.eye(len(f)), G))
        length = np.sqrt(np.einsum("ij,ij->i", rows, rows))
        # A row of zeros stays a row of zeros: its bounds hold everywhere or nowhere.
        length[length == 0.0] = 1.0
        rows, lower, upper = rows / length[:, None], lower / length, upper / length
        equal = lower == upper
        above, below = (lower > -np.inf) & ~equal, (upper < np.inf) & ~equal
        C = np.vstack((rows[equal], rows[above], -rows[below]))
        bounds = np.concatenate((lower[equal], lower[above], -upper[below]))
        # quadprog does not take a matrix without columns.
        constraints = (C.T, bounds, int(equal.sum())) if len(C) else ()
        try:
            x: Array = quadprog.solve_qp(H / size, -f / size, *constraints)[0]
        except ValueError:
            return None
        return x
