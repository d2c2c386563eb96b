"""Move: one straight line in free space."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..trajectories.straight_line import StraightLine
from ..types import Array
from .primitive import Ending, Sensed, Target

SETTLE_TIME = 0.5
"""Rest after the line, so that a recording shows how the error dies away [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class Move:
    """Follow a straight line.

    Attributes:
        displacement: (3,) [m].
        speed: [m/s].
        closure: of the hand.
    """

    displacement: Array
    speed: float
    closure: float = 0.0
    name: str = "line"

    def begin(self, sensed: Sensed, last: Target) -> MovePhase:
        """Start from the last reference pose."""
        return MovePhase(self, sensed, StraightLine(last.reference.pose, self.displacement, self.speed))


@dataclass(frozen=True, slots=True)
class MovePhase:
    """A line under way."""

    plan: Move
    start: Sensed
    line: StraightLine

    def target(self, sensed: Sensed) -> Target:
        """Return the point on the line."""
        return Target(self.line.at(sensed.time - self.start.time), self.plan.closure)

    def force(self, sensed: Sensed) -> float:
        """Return the force on the hand; none is expected in free space."""
        return float(np.linalg.norm(sensed.wrench[:3] - self.start.wrench[:3]))

    def ending(self, sensed: Sensed) -> Ending | None:
        """End when the line and the rest after it are over."""
        over = sensed.time - self.start.time >= self.line.duration + SETTLE_TIME
        return Ending("end of the line") if over else None
