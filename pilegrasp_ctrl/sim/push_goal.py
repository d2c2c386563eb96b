"""Where a push goes to: a wall or a corner, and the line on which it gets there. Pure geometry."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..types import Array

BESIDE = 0.03
"""Nearer to a push in vain than this, another would meet the same objects in the same way: half an object [m]."""


@dataclass(frozen=True, slots=True)
class PushGoal:
    """A wall or a corner that a push of alpha = 0 goes to.

    Attributes:
        name: "wall", "corner_left" or "corner_right", as the arm sees it.
        foot: (2,) point of the wall, or the corner's apex [m].
        yaw: direction of the push of alpha = 0 about z [rad].
        room: within which the hand finds room between walls: least and greatest offset of the push's line to the left
            of `foot` [m]. Equal where there is only one such line.
        nearest: least x of the fingertips at touch-down [m]; nearer than that the wrist would hit the bin's near wall.
    """

    name: str
    foot: Array
    yaw: float
    room: tuple[float, float] = (0.0, 0.0)
    nearest: float = -math.inf

    def lacking(self, touch: Array) -> float:
        """Return how far the hand must come down further along the push than at `touch` (2,) for the wrist [m]."""
        return max(0.0, (self.nearest - float(touch[0])) / math.cos(self.yaw))

    def lane(self, positions: Array, half_width: float, vain: Sequence[PushGoal] = ()) -> tuple[PushGoal, int]:
        """Return the goal with its foot on the line of the push that has most objects before it, and their number.

        Args:
            positions: (n, 2) of the objects [m].
            half_width: an object counts that is at most this far beside the line [m].
            vain: lines that were pushed on in vain. Each that goes to this goal halves what the objects before a line
                beside it count.
        """
        left = np.array([-math.sin(self.yaw), math.cos(self.yaw)])
        least, greatest = self.room
        offsets = np.linspace(least, greatest, 1 + round((greatest - least) / 0.01))
        beside = (positions - self.foot) @ left
        counts = (np.abs(beside[:, None] - offsets) <= half_width).sum(axis=0)
        failed = np.array([(line.foot - self.foot) @ left for line in vain if line.name == self.name])
        worth = counts * 0.5 ** (np.abs(failed[:, None] - offsets) < BESIDE).sum(axis=0)
        # Among equals the one in the middle, where the objects are met squarely.
        best = np.flatnonzero(worth == worth.max())
        chosen = best[len(best) // 2]
        return replace(self, foot=self.foot + offsets[chosen] * left, room=(0.0, 0.0)), int(counts[chosen])
