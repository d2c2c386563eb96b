"""All bounds that are affine in the state, in one product."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np

from ..types import Array


class AffineBounds(NamedTuple):
    """Bounds on the joint accelerations that are affine in the state x = [q; v].

    `lower_matrix x + lower_offset <= a <= upper_matrix x + upper_offset`, matrices (nv, 2 nv), offsets (nv,).
    """

    lower_matrix: Array
    lower_offset: Array
    upper_matrix: Array
    upper_offset: Array


class AffineLimit(Protocol):
    """A limit whose bounds on the accelerations are affine in x = [q; v]."""

    name: str

    def bounds(self) -> AffineBounds:
        """Return the bounds as a function of the state."""


class AccelerationBounds:
    """The tightest of several limits.

    Where limits contradict each other, as for a joint far outside its range, the first one wins, so that a lower bound
    never exceeds the upper one.

    What limits demand of a joint that is outside them is kept to what it can do whatever the others need: a demand
    that the torques cannot meet would be softened together with those of all other joints.

    A limit's two sides are kept as the block [lower; -upper]: the tightest of two blocks is then one maximum. A last
    block [upper; -lower] of the first limit is what no other may exceed.

    Attributes:
        demand: (2 nv,) most that lower bounds, then upper ones, may ask for [rad/s²].
        matrix: ((limits + 1) 2 nv, 2 nv + 1), so that `matrix [x; 1]` are the blocks at x; no rows without limits.
    """

    def __init__(self, limits: Sequence[AffineLimit], nv: int, demand: Array | None = None) -> None:
        """Stack the bounds of `limits`; without any, the accelerations are free.

        Args:
            limits: in the order of their precedence.
            nv: number of joints.
            demand: (nv,) the largest acceleration that a lower bound may ask for, and the largest deceleration that an
                upper one may [rad/s²]; without limit where absent.
        """
        self.demand = np.full(2 * nv, np.inf) if demand is None else np.concatenate((demand, demand))
        self._names = [limit.name for limit in limits]
        sides = [_sides(limit.bounds()) for limit in limits]
        blocks = [np.vstack((lower, -upper)) for lower, upper in sides]
        blocks += [np.vstack((upper, -lower)) for lower, upper in sides[:1]]
        self.matrix: Array = np.vstack([np.zeros((0, 2 * nv + 1)), *blocks])

    def split(self, values: Array) -> list[Array]:
        """Return views (2 nv,) of `values`, which will hold `matrix [x; 1]`: the blocks."""
        return list(values.reshape(-1, self.matrix.shape[1] - 1))

    def intersect(self, blocks: list[Array], lower: Array, upper: Array) -> float:
        """Fill `lower` and `upper` (nv,) from the blocks of `split` at one state.

        Returns:
            How near the nearest bound is: above zero it demands an acceleration, below it allows one [rad/s²].
        """
        if not self._names:
            lower.fill(-np.inf)
            upper.fill(np.inf)
            return -np.inf
        tightest = np.maximum(blocks[0], blocks[-2])
        for block in blocks[1:-2]:
            np.maximum(tightest, block, out=tightest)
        np.minimum(tightest, blocks[-1], out=tightest)
        np.minimum(tightest, self.demand, out=tightest)
        lower[:] = tightest[: len(lower)]
        np.negative(tightest[len(lower) :], out=upper)
        return tightest.item(tightest.argmax())

    def name(self, blocks: list[Array], joint: int, side: str) -> str:
        """Return which limit set the bound of `joint` on `side`, "lower" or "upper"."""
        row = joint if side == "lower" else joint + len(blocks[0]) // 2
        return f"{self._names[int(np.argmax([block[row] for block in blocks[:-1]]))]}[{joint}] {side}"


def _sides(bounds: AffineBounds) -> tuple[Array, Array]:
    """Return lower and upper bounds as matrices (nv, 2 nv + 1) on [x; 1]."""
    return (
        np.column_stack((bounds.lower_matrix, bounds.lower_offset)),
        np.column_stack((bounds.upper_matrix, bounds.upper_offset)),
    )
