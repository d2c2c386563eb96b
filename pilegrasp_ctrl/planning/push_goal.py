"""A push goal in a bin: a wall or a corner, and the best push line to it. Pure geometry."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..types import Array
from ..vectors import components, inner

FAILED_LINE_DISTANCE = 0.03
"""Distance from a failed push line within which a push meets the same objects again [m]: half an object."""

LINE_SPACING = 0.01
"""Distance between the lines that are compared [m]; chosen."""


@dataclass(frozen=True, slots=True)
class PushGoal:
    """A wall or a corner as the goal of a push of alpha = 0.

    Attributes:
        name: "wall", "corner_left" or "corner_right", as the arm sees it.
        anchor: (2,) point of the wall, or the corner's apex [m]. The push runs through it.
        yaw: Direction of the push of alpha = 0 about z [rad].
        lateral_range: Least and greatest offset of the push line to the left of `anchor` [m], within which the hand
            has room between the walls. Both are equal if only one line is possible.
        longest: Greatest distance from `anchor` back to the touch-down of the fingertips [m]. Farther back, hand or arm
            hit a wall.
    """

    name: str
    anchor: Array
    yaw: float
    lateral_range: tuple[float, float] = (0.0, 0.0)
    longest: float = math.inf

    def reach_deficit(self, touch: Array, direction: Array) -> float:
        """Return how much farther along the push the hand must touch down so that hand and arm clear the walls [m].

        Args:
            touch: (2,) planned touch-down point of the fingertips [m].
            direction: (2,) unit vector of the push.
        """
        return max(0.0, inner(self.anchor - touch, direction) - self.longest)

    def best_line(
        self, positions: Array, half_width: float, failed_lines: Sequence[PushGoal] = ()
    ) -> tuple[PushGoal, int]:
        """Return the goal with its anchor on the line that meets most objects, and their number.

        Args:
            positions: (n, 2) object positions [m].
            half_width: Largest distance from the line at which an object counts [m].
            failed_lines: Goals on lines of failed pushes. Each failed line to this goal halves the count of the lines
                near it.
        """
        left = np.array([-math.sin(self.yaw), math.cos(self.yaw)])
        least, greatest = self.lateral_range
        offsets = np.linspace(least, greatest, 1 + round((greatest - least) / LINE_SPACING))
        beside = components(positions - self.anchor, left)
        counts = (np.abs(beside[:, None] - offsets) <= half_width).sum(axis=0)
        failed = np.array([inner(line.anchor - self.anchor, left) for line in failed_lines if line.name == self.name])
        # Each failure takes one from the exponent of two.
        worth = np.ldexp(counts, -(np.abs(failed[:, None] - offsets) < FAILED_LINE_DISTANCE).sum(axis=0))
        # Among equal lines, the middle one meets the objects squarely.
        best = np.flatnonzero(worth == worth.max())
        chosen = best[len(best) // 2]
        return replace(self, anchor=self.anchor + offsets[chosen] * left, lateral_range=(0.0, 0.0)), int(counts[chosen])
