"""Lift: straight up, or back from the support first, then hold."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..trajectories.line_chain import LineChain
from ..trajectories.straight_line import StraightLine
from ..types import Array
from .active_path import ActivePath
from .primitive import NO_FORCE, Ending, PrimitiveInput, Setpoint

UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, slots=True, eq=False)
class Lift:
    """Move up by `height` at `speed` and hold for `hold` seconds with the hand closed.

    Attributes:
        height: [m].
        speed: [m/s].
        hold: [s].
        back: (3,) horizontal way that the hand, from where it is, goes first [m], rising as much; where absent, the
            reference keeps its place and with it the pressure on what is before the hand.
    """

    height: float
    speed: float
    hold: float
    back: Array | None = None
    name: str = "lift"
    tares: ClassVar[bool] = False

    def begin(self, inputs: PrimitiveInput, last: Setpoint) -> ActiveLift:
        """Start from the last reference pose."""
        start = last.reference.pose
        if self.back is None:
            lines: tuple[StraightLine, ...] = (StraightLine(start, self.height * UP, self.speed),)
        else:
            way = (inputs.pose.translation - start.translation + self.back) * (1.0 - UP)
            rise = min(float(np.linalg.norm(way)), self.height)
            away = StraightLine(start, way + rise * UP, self.speed)
            lines = (away, StraightLine(away.end, (self.height - rise) * UP, self.speed))
        return ActiveLift(inputs, LineChain(lines), last.closure, NO_FORCE, self)


@dataclass(frozen=True, slots=True, eq=False)
class ActiveLift(ActivePath):
    """A lift under way."""

    plan: Lift

    def force(self, inputs: PrimitiveInput) -> float:
        """Return the weight that the hand has taken on."""
        return float(-self.change(inputs)[2])

    def ending(self, inputs: PrimitiveInput) -> Ending | None:
        """End when the hand has been held up long enough, if it got there."""
        if self.elapsed(inputs) < self.path.duration + self.plan.hold:
            return None
        short = self.path.lines[-1].end.translation[2] - inputs.pose.translation[2]
        return Ending("lifted") if short < 0.05 else Ending(f"the lift ended {1000 * short:.0f} mm short", failed=True)
