"""Bounds taken as equations, one more or one less at a time: the steps of a dual active-set method."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..types import Array

_PARALLEL = 1e-8
"""A row of length 1 depends on others where no more than this of it stands out of their span."""


class WorkingSet:
    """The point nearest to `goal` on some of the bounds, with what each of them pushes with.

    No bound ever pulls. These are the steps of Goldfarb and Idnani, "A numerically stable dual method for solving
    strictly convex quadratic programs", Mathematical Programming 27, 1983, for a cost that is a sphere.

    Attributes:
        y: (n,) the point.
        index: (a,) which rows are active.
        settled: whether y is in closed form, and not the end of several steps.
    """

    def __init__(self, goal: Array, rows: Array, lower: Array, upper: Array, side: Array) -> None:
        """Start from those of the bounds in `side` that depend on no others and do not pull.

        Args:
            goal: (n,).
            rows: (k, n) of unit length.
            lower: (k,).
            upper: (k,).
            side: (k,) 1 where a lower bound is active, -1 where an upper is, otherwise 0.
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
        """Compute the point from the active rows alone, so that it does not depend on how they came to be active."""
        self.index.sort()
        side = self._side[self.index]
        normals = side[:, None] * self._rows[self.index]
        bounds = np.where(side > 0.0, self._lower[self.index], -self._upper[self.index])
        self._factorise()
        self.y, self._force = self._goal, np.zeros(len(side))
        # The second round takes off what the first rounded.
        for _ in range(2 if len(side) else 0):
            way = self._inverse.T @ (bounds - normals @ self.y)
            self.y = self.y + self._Q @ way
            self._force = self._force + self._inverse @ way
        self.settled = True

    def add(self, row: int, sign: float, gap: float) -> bool:
        """Move on to a point on one more bound, leaving those that would begin to pull.

        Args:
            row: the bound's.
            sign: 1 for the lower bound, -1 for the upper.
            gap: by how much y exceeds it.

        Returns:
            Whether there is such a point; if not, no point is within all bounds.
        """
        normal, own = sign * self._rows[row], 0.0
        self.settled = False
        while True:
            along = self._Q.T @ normal
            way = normal - self._Q @ along
            way -= self._Q @ (self._Q.T @ way)
            square = float(way @ way)
            relief = self._inverse @ along
            full = gap / square if square > _PARALLEL**2 else np.inf
            first, partial = _first_to_pull(self._force, relief)
            step = min(full, partial)
            if step == np.inf:
                return False
            own += step
            self._force = self._force - step * relief
            if full < np.inf:
                self.y = self.y + step * way
                gap -= step * square
            if full <= partial:
                break
            self._keep(np.arange(len(self.index)) != first)
            self._factorise()
        self._side[row] = sign
        self.index, self._force = np.append(self.index, row), np.append(self._force, own)
        length = np.sqrt(square)
        self._Q = np.column_stack((self._Q, way / length))
        below = np.append(np.zeros(len(relief)), 1.0 / length)
        self._inverse = np.vstack((np.column_stack((self._inverse, -relief / length)), below))
        return True

    def _keep(self, kept: NDArray[np.bool_]) -> None:
        self._side[self.index[~kept]] = 0.0
        self.index, self._force = self.index[kept], self._force[kept]

    def _factorise(self) -> None:
        """Keep Q, whose columns span the active rows, and R⁻¹, where Q R are these rows as columns."""
        normals = self._side[self.index, None] * self._rows[self.index]
        self._Q, R = np.linalg.qr(normals.T)
        self._inverse = np.linalg.inv(R)


def _first_to_pull(force: Array, relief: Array) -> tuple[int, float]:
    """Return which bound is the first to pull, and when, as each loses `relief` per unit of the new one; or -1, inf."""
    times = np.full(len(force), np.inf)
    np.divide(force, relief, out=times, where=relief > 0.0)
    if not len(times):
        return -1, np.inf
    first = int(times.argmin())
    return first, float(times[first])
