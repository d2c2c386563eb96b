"""Move: one straight line in free space."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from ..trajectories.line_chain import LineChain
from ..trajectories.straight_line import StraightLine
from ..types import Array
from .active_path import ActivePath
from .primitive import NO_FORCE, Ending, PrimitiveInput, Setpoint

SETTLE_TIME = 0.5
"""Rest after the line, so that a recording shows how the error dies away [s]."""
TOLERANCE = 0.05
"""A tool that is farther from the end than this has not followed the line [m]."""


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
    tares: ClassVar[bool] = True

    def begin(self, inputs: PrimitiveInput, last: Setpoint) -> ActiveMove:
        """Start from the last reference pose."""
        line = StraightLine(last.reference.pose, self.displacement, self.speed)
        return ActiveMove(inputs, LineChain((line,)), self.closure, NO_FORCE)


@dataclass(frozen=True, slots=True, eq=False)
class ActiveMove(ActivePath):
    """A line under way."""

    def ending(self, inputs: PrimitiveInput) -> Ending | None:
        """End when the line and the rest after it are over, if the tool got there."""
        if self.elapsed(inputs) < self.path.duration + SETTLE_TIME:
            return None
        away = math.dist(inputs.pose.translation, self.path.lines[-1].end.translation)
        if away > TOLERANCE:
            return Ending(f"the line ended {1000 * away:.0f} mm away from its end", failed=True)
        return Ending("end of the line")
