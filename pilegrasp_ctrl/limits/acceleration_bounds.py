"""Bounds on the joint accelerations that are affine in the state, evaluated in one product."""

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
    """A limit whose bounds on the accelerations are affine in x = [q; v].

    Attributes:
        name: Name of the limit in `active_limits`.
    """

    name: str

    def bounds(self) -> AffineBounds:
        """Return the bounds as a function of the state."""


class AccelerationBounds:
    """The tightest bounds of several limits.

    If limits contradict each other, as for a joint far outside its range, the first one wins. A lower bound therefore
    never exceeds the upper one.

    The demand on a joint outside its limits is bounded by an acceleration that the joint can reach in any posture. A
    larger demand could exceed the torques, and the bounds of all joints would then be softened.

    The two sides of a limit are stored as the block [lower; -upper], so the tightest of two blocks is one maximum. The
    last block, [upper; -lower] of the first limit, bounds all other limits.

    Attributes:
        demand: (2 nv,) Largest demand of the lower bounds, then of the upper ones [rad/s²].
        matrix: ((limits + 1) 2 nv, 2 nv + 1) Matrix with the blocks `matrix [x; 1]` at x; no rows without limits.
    """

    def __init__(self, limits: Sequence[AffineLimit], nv: int, demand: Array | None = None) -> None:
        """Stack the bounds of `limits`; without limits, the accelerations are free.

        Args:
            limits: Limits in the order of their precedence.
            nv: Number of joints.
            demand: (nv,) Largest acceleration that a lower bound may ask for; likewise the deceleration of an upper one
                [rad/s²]. Unlimited by default.
        """
        self.demand = np.full(2 * nv, np.inf) if demand is None else np.concatenate((demand, demand))
        self._names = [limit.name for limit in limits]
        sides = [_sides(limit.bounds()) for limit in limits]
        blocks = [np.vstack((lower, -upper)) for lower, upper in sides]
        blocks += [np.vstack((upper, -lower)) for lower, upper in sides[:1]]
        self.matrix: Array = np.vstack([np.zeros((0, 2 * nv + 1)), *blocks])

    def __repr__(self) -> str:
        return f"AccelerationBounds({', '.join(self._names) or 'none'})"

    def split(self, values: Array) -> list[Array]:
        """Return the blocks (2 nv,) as views of `values`, an array that will hold `matrix [x; 1]`."""
        return list(values.reshape(-1, self.matrix.shape[1] - 1))

    def intersect(self, blocks: list[Array], lower: Array, upper: Array) -> float:
        """Fill `lower` and `upper` (nv,) from the blocks of `split` at one state.

        Returns:
            Value of the nearest bound [rad/s²]: a positive bound demands an acceleration, a negative one leaves room.
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
        """Return the name of the limit that bounds `joint` on `side`, "lower" or "upper"."""
        row = joint if side == "lower" else joint + len(blocks[0]) // 2
        return f"{self._names[int(np.argmax([block[row] for block in blocks[:-1]]))]}[{joint}] {side}"


def _sides(bounds: AffineBounds) -> tuple[Array, Array]:
    """Return lower and upper bounds as matrices (nv, 2 nv + 1) on [x; 1]."""
    return (
        np.column_stack((bounds.lower_matrix, bounds.lower_offset)),
        np.column_stack((bounds.upper_matrix, bounds.upper_offset)),
    )
