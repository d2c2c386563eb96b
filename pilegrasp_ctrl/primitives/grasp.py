"""Grasp: close the fingers, or tilt the scoop back."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..trajectories.straight_line import StraightLine
from ..types import Pose, Reference
from .primitive import Ending, Sensed, Target

SCOOP_ANGULAR_SPEED = 0.6
"""Of the scoop while it tilts back [rad/s]."""


@dataclass(frozen=True, slots=True)
class Grasp:
    """Close for `duration` and, for a scoop, tilt back by `scoop_angle` about its heel.

    Attributes:
        duration: of the closing [s].
        scoop_angle: [rad]; zero for a hand that closes.
        heel: distance from the leading edge to the heel [m].
        slope: of the floor before the scoop [rad].
    """

    duration: float
    scoop_angle: float = 0.0
    heel: float = 0.0
    slope: float = 0.0
    name: str = "grasp"

    def begin(self, sensed: Sensed, last: Target) -> GraspPhase:
        """Stop where the hand is: the reference ran ahead of it by what the force asked for."""
        here = last.reference.pose
        if self.scoop_angle == 0.0:
            return GraspPhase(self, sensed, here, None)
        # The edge moves on an arc about the heel, which must not be pressed into the support.
        before, after = self.slope, self.slope - self.scoop_angle
        forward = self.heel * (math.cos(after) - math.cos(before))
        upward = self.heel * (math.sin(before) - math.sin(after))
        push = here.rotation[:, 0] * np.array([1.0, 1.0, 0.0])
        push /= np.linalg.norm(push)
        displacement = forward * push + np.array([0.0, 0.0, upward])
        turn = -self.scoop_angle * here.rotation[:, 1]
        line = StraightLine(here, displacement, 1.0, rotation=turn, angular_speed=SCOOP_ANGULAR_SPEED)
        return GraspPhase(self, sensed, here, line)


@dataclass(frozen=True, slots=True)
class GraspPhase:
    """A grasp under way."""

    plan: Grasp
    start: Sensed
    here: Pose
    scoop: StraightLine | None

    def target(self, time: float) -> Target:
        """Hold the pose, or follow the scoop, with the hand closed."""
        reference = self.scoop.at(time - self.start.time) if self.scoop else Reference(self.here)
        return Target(reference, 1.0)

    def force(self, sensed: Sensed) -> float:
        """Return how much the force on the hand has changed."""
        return float(np.linalg.norm(sensed.wrench[:3] - self.start.wrench[:3]))

    def ending(self, sensed: Sensed) -> Ending | None:
        """End when the closing has had its time; the hand has no sensor that could tell more."""
        needed = self.plan.duration if self.scoop is None else max(self.plan.duration, self.scoop.duration + 0.2)
        return Ending("closed") if sensed.time - self.start.time >= needed else None
