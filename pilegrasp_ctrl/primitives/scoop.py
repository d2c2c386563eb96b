"""Scoop: the shovel's grasp; it tilts back."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..trajectories.line_chain import LineChain
from ..trajectories.straight_line import StraightLine
from .active_path import ActivePath
from .primitive import NO_FORCE, Ending, PrimitiveInput, Setpoint

ANGULAR_SPEED = 0.6
"""Of the tilt [rad/s]."""
REST_TIME = 0.2
"""After the tilt [s]."""


@dataclass(frozen=True, slots=True)
class Scoop:
    """Tilt back by `angle` about the heel.

    Attributes:
        angle: [rad].
        heel: distance from the leading edge to the heel [m].
        slope: of the floor before the tilt [rad].
    """

    angle: float
    heel: float
    slope: float
    name: str = "grasp"
    tares: ClassVar[bool] = False

    def begin(self, inputs: PrimitiveInput, last: Setpoint) -> ActiveScoop:
        """Start from the last reference pose.

        The edge goes along the chord of its arc about the heel, which must not be pressed into the support.
        """
        here = last.reference.pose
        before, after = self.slope, self.slope - self.angle
        forward = self.heel * (math.cos(after) - math.cos(before))
        upward = self.heel * (math.sin(before) - math.sin(after))
        level = here.rotation[:, 0] * np.array([1.0, 1.0, 0.0])
        displacement = forward * level / np.linalg.norm(level) + np.array([0.0, 0.0, upward])
        turn = -self.angle * here.rotation[:, 1]
        line = StraightLine(here, displacement, 1.0, rotation=turn, angular_speed=ANGULAR_SPEED)
        return ActiveScoop(inputs, LineChain((line,)), last.closure, NO_FORCE)


@dataclass(frozen=True, slots=True, eq=False)
class ActiveScoop(ActivePath):
    """A scoop under way."""

    def ending(self, inputs: PrimitiveInput) -> Ending | None:
        """End when the tilt is over."""
        return Ending("tilted back") if self.elapsed(inputs) >= self.path.duration + REST_TIME else None
