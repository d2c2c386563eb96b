"""A push goal in a bin: a wall or a corner, and the line on which the push gets there. Pure geometry."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..types import Array

NEAR_A_FAILED_LINE = 0.03
"""Distance from a failed push within which a push meets the same objects again [m]: half an object."""

LINE_SPACING = 0.01
"""Distance between the lines that are compared [m]."""


@dataclass(frozen=True, slots=True)
class PushGoal:
    """A wall or a corner that a push of alpha = 0 goes to.

    Attributes:
        name: "wall", "corner_left" or "corner_right", as the arm sees it.
        anchor: (2,) point of the wall, or the corner's apex [m]. The push runs through it.
        yaw: Direction of the push of alpha = 0 about z [rad].
        lateral_range: Least and greatest offset of the push line to the left of `anchor` [m], within which the hand
            has room between the walls. Equal if only one line is possible.
        nearest: Least x of the fingertips at touch-down [m]. If they come down nearer, the wrist hits the bin's near
            wall.
    """

    name: str
    anchor: Array
    yaw: float
    lateral_range: tuple[float, float] = (0.0, 0.0)
    nearest: float = -math.inf

    def reach_deficit(self, touch: Array) -> float:
        """Return how much farther along the push than `touch` (2,) the hand must touch down [m].

        The wrist clears the bin's near wall there.
        """
        return max(0.0, (self.nearest - float(touch[0])) / math.cos(self.yaw))

    def best_line(
        self, positions: Array, half_width: float, failed_lines: Sequence[PushGoal] = ()
    ) -> tuple[PushGoal, int]:
        """Return the goal with its anchor on the line that has most objects before it, and their number.

        Args:
            positions: (n, 2) object positions [m].
            half_width: An object counts if it is at most this far beside the line [m].
            failed_lines: Goals on lines of failed pushes. Each failed line to this goal halves the count of the lines
                near it.
        """
        left = np.array([-math.sin(self.yaw), math.cos(self.yaw)])
        least, greatest = self.lateral_range
        offsets = np.linspace(least, greatest, 1 + round((greatest - least) / LINE_SPACING))
        beside = (positions - self.anchor) @ left
        counts = (np.abs(beside[:, None] - offsets) <= half_width).sum(axis=0)
        failed = np.array([(line.anchor - self.anchor) @ left for line in failed_lines if line.name == self.name])
        worth = counts * 0.5 ** (np.abs(failed[:, None] - offsets) < NEAR_A_FAILED_LINE).sum(axis=0)
        # Among equal lines, the middle one meets the objects squarely.
        best = np.flatnonzero(worth == worth.max())
        chosen = best[len(best) // 2]
        return replace(self, anchor=self.anchor + offsets[chosen] * left, lateral_range=(0.0, 0.0)), int(counts[chosen])
