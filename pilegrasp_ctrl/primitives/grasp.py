"""Grasp: close the fingers, or tilt the scoop back."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..trajectories.straight_line import StraightLine
from ..types import Array, Pose
from .primitive import Ending, Sensed, Target

SCOOP_ANGULAR_SPEED = 0.6
"""Of the scoop while it tilts back [rad/s]."""
ADVANCE_SHARE = 0.7
"""Share of the closing time in which the reference advances."""


@dataclass(frozen=True, slots=True, eq=False)
class Grasp:
    """Close for `duration` and, for a scoop, tilt back by `scoop_angle` about its heel.

    The reference goes on along the push while the fingers close, so that the hand keeps its pressure on the pile; the
    authors' arm does the same by being soft (at 17 N its reference is some 0.1 m ahead of it).

    Attributes:
        duration: of the closing [s].
        advance: (3,) of the reference while the hand closes, in world axes [m].
        scoop_angle: [rad]; zero for a hand that closes.
        heel: distance from the leading edge to the heel [m].
        slope: of the floor before the scoop [rad].
    """

    duration: float
    advance: Array
    scoop_angle: float = 0.0
    heel: float = 0.0
    slope: float = 0.0
    name: str = "grasp"

    def begin(self, sensed: Sensed, last: Target) -> GraspPhase:
        """Start from the last reference pose."""
        here = last.reference.pose
        if self.scoop_angle > 0.0:
            return GraspPhase(self, sensed, self._scoop(here))
        pace = float(np.linalg.norm(self.advance)) / (ADVANCE_SHARE * self.duration)
        return GraspPhase(self, sensed, StraightLine(here, self.advance, max(pace, 1e-3)))

    def _scoop(self, here: Pose) -> StraightLine:
        """Return the edge's way: an arc about the heel, which must not be pressed into the support, and its chord."""
        before, after = self.slope, self.slope - self.scoop_angle
        forward = self.heel * (math.cos(after) - math.cos(before))
        upward = self.heel * (math.sin(before) - math.sin(after))
        level = here.rotation[:, 0] * np.array([1.0, 1.0, 0.0])
        displacement = forward * level / np.linalg.norm(level) + np.array([0.0, 0.0, upward])
        turn = -self.scoop_angle * here.rotation[:, 1]
        return StraightLine(here, displacement, 1.0, rotation=turn, angular_speed=SCOOP_ANGULAR_SPEED)


@dataclass(frozen=True, slots=True)
class GraspPhase:
    """A grasp under way."""

    plan: Grasp
    start: Sensed
    line: StraightLine

    def target(self, time: float) -> Target:
        """Return the point on the line, the hand closed."""
        return Target(self.line.at(time - self.start.time), 1.0)

    def force(self, sensed: Sensed) -> float:
        """Return how much the force on the hand has changed."""
        return float(np.linalg.norm(sensed.wrench[:3] - self.start.wrench[:3]))

    def ending(self, sensed: Sensed) -> Ending | None:
        """End when the closing has had its time; the hand has no sensor that could tell more."""
        needed = max(self.plan.duration, self.line.duration + 0.2)
        return Ending("closed") if sensed.time - self.start.time >= needed else None
