"""DAQP: a dual active-set method, exact and the fastest of those measured."""

from __future__ import annotations

import daqp
import numpy as np

from ..types import Array
from .qp import QuadraticProgram

_SOFT = 8


class DaqpSolver:
    """Solves each program from scratch; at this size a warm start gains nothing, and answers do not depend on history.

    Attributes:
        name: "daqp".
    """

    name = "daqp"

    def __init__(self, n: int, m: int) -> None:
        """Prepare for n variables and m rows."""
        self._hard = np.zeros(n + m, dtype=np.int32)
        self._soft = self._hard.copy()
        self._soft[:n] = _SOFT

    def solve(self, problem: QuadraticProgram, soft: bool) -> Array | None:
        """Return x (n,), or None where DAQP finds none."""
        H, f, G, lower, upper = problem
        sense = self._soft if soft else self._hard
        x, _, flag, _ = daqp.solve(H, f, G, upper, lower, sense, iter_limit=1000)
        return x if flag > 0 else None
