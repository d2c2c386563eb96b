"""DAQP: a dual active-set method, exact and the fastest of the measured solvers."""

from __future__ import annotations

import daqp
import numpy as np
from numpy.typing import NDArray

from ..types import Array
from .program import QuadraticProgram

_TOLERANCE = 1e-9
"""Largest excess of a bound [rad/s², N·m]; DAQP's default of 1e-6 is no faster and less exact."""


class DaqpSolver:
    """Solves each program from scratch.

    At this size a warm start gains nothing. Without it, answers do not depend on history.

    Attributes:
        name: "daqp".
    """

    name = "daqp"

    def __init__(self) -> None:
        """Start without an array of constraint types; `solve` makes one for each size of program."""
        self._constraint_types: dict[int, NDArray[np.int32]] = {}

    def solve(self, problem: QuadraticProgram) -> Array | None:
        """Return x (n,), or None if DAQP finds none."""
        H, f, G, lower, upper = problem
        rows = len(lower)
        constraint_types = self._constraint_types.get(rows)
        if constraint_types is None:
            constraint_types = self._constraint_types[rows] = np.zeros(rows, dtype=np.int32)
        x, _, flag, _ = daqp.solve(H, f, G, upper, lower, constraint_types, primal_tol=_TOLERANCE)
        return x if flag > 0 else None
