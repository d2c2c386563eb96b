"""All bounds that are affine in the state, in one product."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from ..types import Array
from .constraint import AffineBounds


class AffineLimit(Protocol):
    """A limit whose bounds on the accelerations are affine in [q; v]."""

    name: str

    def bounds(self) -> AffineBounds:
        """Return the bounds as a function of the state."""


class AccelerationBounds:
    """The tightest of several limits, later ones kept inside the first.

    Where limits contradict each other, as for a joint far outside its range, the earlier one wins, so that the lower
    bound never exceeds the upper one.
    """

    def __init__(self, limits: Sequence[AffineLimit], nv: int) -> None:
        """Stack the limits' bounds; without limits the accelerations are free."""
        self._names = [limit.name for limit in limits]
        bounds = [limit.bounds() for limit in limits]
        rows = 2 * len(bounds) * nv
        self._matrix = np.zeros((rows, 2 * nv))
        self._offset = np.zeros(rows)
        for index, item in enumerate(bounds):
            at = 2 * index * nv
            self._matrix[at : at + nv], self._offset[at : at + nv] = item.lower_matrix, item.lower_offset
            self._matrix[at + nv : at + 2 * nv] = item.upper_matrix
            self._offset[at + nv : at + 2 * nv] = item.upper_offset
        self._x = np.zeros(2 * nv)
        self._y = np.zeros(rows)
        self._views = self._y.reshape(len(bounds), 2, nv)
        self._nv = nv

    def write(self, lower: Array, upper: Array, q: Array, v: Array) -> None:
        """Fill `lower` and `upper` (nv,) [rad/s²] for one state."""
        if not self._names:
            lower.fill(-np.inf)
            upper.fill(np.inf)
            return
        self._x[: self._nv] = q
        self._x[self._nv :] = v
        np.dot(self._matrix, self._x, out=self._y)
        self._y += self._offset
        first_lower, first_upper = self._views[0]
        lower[:], upper[:] = first_lower, first_upper
        for other_lower, other_upper in self._views[1:]:
            np.maximum(lower, other_lower, out=lower)
            np.minimum(upper, other_upper, out=upper)
        if len(self._names) > 1:
            np.minimum(lower, first_upper, out=lower)
            np.maximum(upper, first_lower, out=upper)

    def name(self, joint: int, side: str) -> str:
        """Return which limit set the bound of `joint` on `side`, "lower" or "upper", at the last state written."""
        column = self._views[:, 0 if side == "lower" else 1, joint]
        index = int(np.argmax(column) if side == "lower" else np.argmin(column))
        return f"{self._names[index]}[{joint}] {side}"
