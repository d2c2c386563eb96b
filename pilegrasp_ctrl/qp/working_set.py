"""The working set of a dual active-set method: bounds that count as equations, added and dropped one by one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..types import Array

_PARALLEL = 1e-8
"""Length outside the span of the other rows below which a row of length 1 counts as dependent; chosen."""


class WorkingSet:
    """The point nearest to `goal` on the active bounds, with the force (multiplier) of each bound.

    No bound ever pulls: no force is negative. The steps are those of Goldfarb and Idnani, "A numerically stable dual
    method for solving strictly convex quadratic programs", Mathematical Programming 27, 1983, for a cost that is a
    sphere.

    Attributes:
        y: (n,) Nearest point.
        index: (a,) Indices of the active rows.
        settled: Whether y is the closed form for the active rows; after `add` it is the end of several steps.
    """

    def __init__(self, goal: Array, rows: Array, lower: Array, upper: Array, side: Array) -> None:
        """Start from the bounds in `side` that are independent of each other and do not pull.

        Args:
            goal: (n,) Point to be near to.
            rows: (k, n) Rows of unit length.
            lower: (k,) Lower bounds.
            upper: (k,) Upper bounds.
            side: (k,) 1 for an active lower bound, -1 for an active upper one, otherwise 0.
        """
        self._goal, self._rows, self._lower, self._upper = goal, rows, lower, upper
        self._Q: Array = np.zeros((len(goal), 0))
        self._inverse: Array = np.zeros((0, 0))
        self._side = side.copy()
        self.index: NDArray[np.intp] = np.flatnonzero(side)
        self._force = np.zeros(len(self.index))
        self.y, self.settled = goal, True
        if not len(self.index):
            return
        R = np.linalg.qr(rows[self.index].T, mode="r")
        independent = np.zeros(len(self.index), dtype=bool)
        independent[: len(R)] = np.abs(np.diagonal(R)) > _PARALLEL
        self._keep(independent)
        self.settle()
        while (pulling := self._force < 0.0).any():
            self._keep(~pulling)
            self.settle()

    def settle(self) -> None:
        """Compute the point from the active rows alone, independent of the steps that led to them."""
        self.index.sort()
        side = self._side[self.index]
        normals = side[:, None] * self._rows[self.index]
        bounds = np.where(side > 0.0, self._lower[self.index], -self._upper[self.index])
        self._factorise()
        self.y, self._force = self._goal, np.zeros(len(side))
        # The second iteration removes the round-off of the first.
        for _ in range(2 if len(side) else 0):
            step = self._inverse.T @ (bounds - normals @ self.y)
            self.y = self.y + self._Q @ step
            self._force = self._force + self._inverse @ step
        self.settled = True

    def add(self, row: int, sign: float, gap: float) -> bool:
        """Move to a point on one more bound, and drop the bounds that would begin to pull.

        Args:
            row: Row of the bound.
            sign: 1 for the lower bound, -1 for the upper.
            gap: Excess of the bound at y.

        Returns:
            Whether such a point exists; otherwise no point is within all bounds.
        """
        normal, force = sign * self._rows[row], 0.0
        self.settled = False
        while True:
            along = self._Q.T @ normal
            across = normal - self._Q @ along
            across -= self._Q @ (self._Q.T @ across)
            square = float(across @ across)
            relief = self._inverse @ along
            full = gap / square if square > _PARALLEL**2 else np.inf
            first, partial = _first_to_pull(self._force, relief)
            step = min(full, partial)
            if step == np.inf:
                return False
            force += step
            self._force = self._force - step * relief
            if full < np.inf:
                self.y = self.y + step * across
                gap -= step * square
            if full <= partial:
                break
            self._keep(np.arange(len(self.index)) != first)
            self._factorise()
        self._side[row] = sign
        self.index, self._force = np.append(self.index, row), np.append(self._force, force)
        length = np.sqrt(square)
        self._Q = np.column_stack((self._Q, across / length))
        below = np.append(np.zeros(len(relief)), 1.0 / length)
        self._inverse = np.vstack((np.column_stack((self._inverse, -relief / length)), below))
        return True

    def _keep(self, kept: NDArray[np.bool_]) -> None:
        self._side[self.index[~kept]] = 0.0
        self.index, self._force = self.index[kept], self._force[kept]

    def _factorise(self) -> None:
        """Store Q and R⁻¹ of the factorisation Q R of the active rows as columns."""
        normals = self._side[self.index, None] * self._rows[self.index]
        self._Q, R = np.linalg.qr(normals.T)
        self._inverse = np.linalg.inv(R)


def _first_to_pull(force: Array, relief: Array) -> tuple[int, float]:
    """Return the first bound to pull and the step at which it does, or -1 and inf.

    Each bound loses `relief` of its force per unit of the new bound's.
    """
    times = np.full(len(force), np.inf)
    np.divide(force, relief, out=times, where=relief > 0.0)
    if not len(times):
        return -1, np.inf
    first = int(times.argmin())
    return first, float(times[first])
