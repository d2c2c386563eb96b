"""DAQP: a dual active-set method, exact and the fastest of the measured solvers."""

from __future__ import annotations

import daqp
import numpy as np

from ..types import Array
from .program import QuadraticProgram

_TOLERANCE = 1e-9
"""Largest excess of a bound [rad/s², N·m]; DAQP's default of 1e-6 is no faster and less exact."""


class DaqpSolver:
    """Solves each program from scratch, so that answers do not depend on history; a warm start would gain nothing."""

    name = "daqp"
    reads_only = True

    def __repr__(self) -> str:
        return "DaqpSolver()"

    def solve(self, program: QuadraticProgram) -> Array | None:
        """Return x (n,), or None if DAQP finds none."""
        H, f, G, lower, upper = program
        constraint_types = np.zeros(len(lower), dtype=np.int32)
        x, _, flag, _ = daqp.solve(H, f, G, upper, lower, constraint_types, primal_tol=_TOLERANCE)
        return x if flag > 0 else None
