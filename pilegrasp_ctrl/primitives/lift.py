"""Lift: straight up, then hold."""

from __future__ import annotations

from dataclasses import dataclass

from ..trajectories.straight_line import StraightLine
from .primitive import Ending, Sensed, Target


@dataclass(frozen=True, slots=True)
class Lift:
    """Move up by `height` at `speed` and hold for `hold` seconds with the hand closed."""

    height: float
    speed: float
    hold: float
    name: str = "lift"

    def begin(self, sensed: Sensed, last: Target) -> LiftPhase:
        """Start from the last reference pose."""
        return LiftPhase(
            self, sensed, StraightLine(last.reference.pose, [0.0, 0.0, self.height], self.speed), last.closure
        )


@dataclass(frozen=True, slots=True)
class LiftPhase:
    """A lift under way."""

    plan: Lift
    start: Sensed
    line: StraightLine
    closure: float

    def target(self, sensed: Sensed) -> Target:
        """Return the point on the line."""
        return Target(self.line.at(sensed.time - self.start.time), self.closure)

    def force(self, sensed: Sensed) -> float:
        """Return the weight that the hand has taken on."""
        return float(self.start.wrench[2] - sensed.wrench[2])

    def ending(self, sensed: Sensed) -> Ending | None:
        """End when the hand has been held up long enough, if it got there."""
        if sensed.time - self.start.time < self.line.duration + self.plan.hold:
            return None
        short = self.line.end.translation[2] - sensed.pose.translation[2]
        return Ending("lifted") if short < 0.05 else Ending(f"the lift ended {1000 * short:.0f} mm short", failed=True)
