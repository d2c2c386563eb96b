"""DAQP: a dual active-set method, exact and the fastest of those measured."""

from __future__ import annotations

import daqp

from ..types import Array
from .qp import QuadraticProgram


class DaqpSolver:
    """Solves each program from scratch; at this size a warm start gains nothing, and answers do not depend on history.

    Attributes:
        name: "daqp".
    """

    name = "daqp"

    def solve(self, problem: QuadraticProgram) -> Array | None:
        """Return x (n,), or None where DAQP finds none."""
        H, f, G, lower, upper = problem
        x, _, flag, _ = daqp.solve(H, f, G, upper, lower, iter_limit=1000)
        return x if flag > 0 else None
