"""Grasp: close the fingers while the hand keeps its pressure on the pile."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..types import Reference
from .pressure import Pressure, PressureKept
from .primitive import Ending, Sensed, Target


@dataclass(frozen=True, slots=True, eq=False)
class Grasp:
    """Close for `duration`.

    Attributes:
        duration: of the closing [s].
        pressure: on the pile meanwhile.
    """

    duration: float
    pressure: Pressure
    name: str = "grasp"
    tares: ClassVar[bool] = False

    def begin(self, sensed: Sensed, last: Target) -> GraspPhase:
        """Start from the last reference pose, at F_grasp."""
        return GraspPhase(self, sensed, Reference(last.reference.pose), PressureKept(self.pressure, sensed))


@dataclass(frozen=True, slots=True, eq=False)
class GraspPhase:
    """A grasp under way."""

    plan: Grasp
    start: Sensed
    here: Reference
    kept: PressureKept

    def target(self, sensed: Sensed) -> Target:
        """Follow what gives way, the hand closed."""
        return Target(self.kept.move(self.here, sensed), 1.0)

    def force(self, sensed: Sensed) -> float:
        """Return how much the force on the hand has changed."""
        return float(np.linalg.norm(sensed.wrench[:3] - self.start.wrench[:3]))

    def ending(self, sensed: Sensed) -> Ending | None:
        """End when the closing has had its time; the hand has no sensor that could tell more."""
        return Ending("closed") if sensed.time - self.start.time >= self.plan.duration else None
