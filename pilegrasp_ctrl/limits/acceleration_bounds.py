"""All bounds that are affine in the state, in one product."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from ..types import Array
from .constraint import AffineBounds


class AffineLimit(Protocol):
    """A limit whose bounds on the accelerations are affine in x = [q; v]."""

    name: str

    def bounds(self) -> AffineBounds:
        """Return the bounds as a function of the state."""


class AccelerationBounds:
    """The tightest of several limits.

    Where limits contradict each other, as for a joint far outside its range, the first one wins, so that a lower bound
    never exceeds the upper one.

    Attributes:
        matrix: (2 nv limits, 2 nv), lower and upper bounds of each limit in turn.
        offset: (2 nv limits,), so that `matrix x + offset` are the bounds at x.
    """

    def __init__(self, limits: Sequence[AffineLimit], nv: int) -> None:
        """Stack the bounds of `limits`; without any, the accelerations are free."""
        self._names = [limit.name for limit in limits]
        bounds = [limit.bounds() for limit in limits]
        matrices = [matrix for item in bounds for matrix in (item.lower_matrix, item.upper_matrix)]
        self.matrix: Array = np.vstack([np.zeros((0, 2 * nv)), *matrices])
        offsets = [offset for item in bounds for offset in (item.lower_offset, item.upper_offset)]
        self.offset: Array = np.concatenate([np.zeros(0), *offsets])

    def split(self, values: Array) -> list[tuple[Array, Array]]:
        """Return views of `values`, which will hold `matrix x + offset`: lower and upper bounds (nv,) of each limit."""
        nv = self.matrix.shape[1] // 2
        return [(lower, upper) for lower, upper in values.reshape(-1, 2, nv)]

    def intersect(self, values: list[tuple[Array, Array]], lower: Array, upper: Array) -> None:
        """Fill `lower` and `upper` (nv,) from the bounds of each limit at one state."""
        if not self._names:
            lower.fill(-np.inf)
            upper.fill(np.inf)
            return
        first_lower, first_upper = values[0]
        last_lower, last_upper = values[-1]
        np.maximum(first_lower, last_lower, out=lower)
        np.minimum(first_upper, last_upper, out=upper)
        for other_lower, other_upper in values[1:-1]:
            np.maximum(lower, other_lower, out=lower)
            np.minimum(upper, other_upper, out=upper)
        np.minimum(lower, first_upper, out=lower)
        np.maximum(upper, first_lower, out=upper)

    def name(self, values: list[tuple[Array, Array]], joint: int, side: str) -> str:
        """Return which limit set the bound of `joint` on `side`, "lower" or "upper"."""
        if side == "lower":
            index = int(np.argmax([lower[joint] for lower, _ in values]))
        else:
            index = int(np.argmin([upper[joint] for _, upper in values]))
        return f"{self._names[index]}[{joint}] {side}"
