"""Release: open the hand and wait until what it held has fallen out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..trajectories.line_chain import LineChain
from ..trajectories.straight_line import StraightLine
from .active_path import ActivePath
from .primitive import NO_FORCE, Ending, PrimitiveInput, Setpoint


@dataclass(frozen=True, slots=True)
class Release:
    """Keep the place and open the hand for `duration` [s]; the fingers' slope does the rest."""

    duration: float
    name: str = "release"
    tares: ClassVar[bool] = True

    def begin(self, inputs: PrimitiveInput, last: Setpoint) -> ActiveRelease:
        """Stay at the last reference pose."""
        still = StraightLine(last.reference.pose, np.zeros(3), 1.0)
        return ActiveRelease(inputs, LineChain((still,)), 0.0, NO_FORCE, self)


@dataclass(frozen=True, slots=True, eq=False)
class ActiveRelease(ActivePath):
    """A release under way."""

    plan: Release

    def ending(self, inputs: PrimitiveInput) -> Ending | None:
        """End when the hand has been open long enough; it has no sensor that could tell more."""
        return Ending("opened") if self.elapsed(inputs) >= self.plan.duration else None
