"""A solver as one would first think of it: one call of qpsolvers with everything at its default."""

from __future__ import annotations

import numpy as np
import qpsolvers

from pilegrasp_ctrl.qp.program import QuadraticProgram
from pilegrasp_ctrl.types import Array


class NaiveSolver:
    """`qpsolvers.solve_qp`, which believes the package's own tolerances and status; for contrast only.

    Attributes:
        name: the package's, with "naive".
    """

    def __init__(self, package: str) -> None:
        """Choose one of `qpsolvers.available_solvers`."""
        self.name = f"naive {package}"
        self._package = package

    def solve(self, problem: QuadraticProgram) -> Array | None:
        """Return x (n,), or None where the package finds none."""
        H, f, G, lower, upper = problem
        n = len(f)
        # qpsolvers has one-sided rows only.
        rows, bounds = np.vstack((G, -G)), np.concatenate((upper[n:], -lower[n:]))
        x: Array | None = qpsolvers.solve_qp(H, f, rows, bounds, lb=lower[:n], ub=upper[:n], solver=self._package)
        return x
