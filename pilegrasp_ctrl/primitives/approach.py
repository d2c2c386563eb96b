"""Approach: a straight line in free space, then down until the surface pushes back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..trajectories.straight_line import StraightLine
from ..types import Pose
from .primitive import Ending, Sensed, Target

SEARCH_DEPTH = 0.05
"""How far below the expected surface the descent goes on before it gives up [m]."""


@dataclass(frozen=True, slots=True)
class Approach:
    """Move to `pre_grasp`, then down until the normal force exceeds `touch_force`.

    Attributes:
        pre_grasp: tool pose above the place of touch-down.
        height: of the pre-grasp pose above the surface [m].
        speed: of the free-space line [m/s].
        touch_speed: of the descent [m/s].
        touch_force: normal force relative to the primitive's start [N].
        closure: preshape of the hand.
    """

    pre_grasp: Pose
    height: float
    speed: float
    touch_speed: float
    touch_force: float
    closure: float
    name: str = "approach"

    def begin(self, sensed: Sensed, last: Target) -> ApproachPhase:
        """Start from the last reference pose."""
        start = last.reference.pose
        across = StraightLine(start, self.pre_grasp.translation - start.translation, self.speed)
        down = StraightLine(across.end, [0.0, 0.0, -(self.height + SEARCH_DEPTH)], self.touch_speed)
        return ApproachPhase(self, sensed, across, down)


@dataclass(frozen=True, slots=True)
class ApproachPhase:
    """An approach under way."""

    plan: Approach
    start: Sensed
    across: StraightLine
    down: StraightLine

    def target(self, sensed: Sensed) -> Target:
        """Return the point on the first line, then on the second."""
        elapsed = sensed.time - self.start.time
        descending = elapsed - self.across.duration
        reference = self.across.at(elapsed) if descending < 0.0 else self.down.at(descending)
        return Target(reference, self.plan.closure)

    def force(self, sensed: Sensed) -> float:
        """Return the surface's normal force."""
        return float(sensed.wrench[2] - self.start.wrench[2])

    def ending(self, sensed: Sensed) -> Ending | None:
        """End at the surface; a contact before the descent is a collision."""
        elapsed = sensed.time - self.start.time
        if elapsed < self.across.duration:
            blow = np.linalg.norm(sensed.wrench[:3] - self.start.wrench[:3])
            return Ending("collision in free space", failed=True) if blow > 5.0 * self.plan.touch_force else None
        if self.force(sensed) > self.plan.touch_force:
            return Ending("surface contact")
        if elapsed > self.across.duration + self.down.duration + 0.5:
            return Ending("travel limit: no surface", failed=True)
        return None
