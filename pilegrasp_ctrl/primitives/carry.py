"""Carry: up where it is safe, then across to a pose, with or without something in the hand."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pinocchio as pin

from ..trajectories.line_chain import LineChain
from ..trajectories.straight_line import StraightLine
from ..types import Pose
from .active_path import ActivePath
from .move import TOLERANCE
from .primitive import NO_FORCE, Ending, PrimitiveInput, Setpoint

REST_TIME = 0.3
"""After the motion, so that what hangs in the hand comes to rest [s]."""
BACK = 0.06
"""A hand that is down in the bin backs off by this much on its way up, so that it does not wipe over the rim [m]."""
ANGULAR_SPEED = 0.6


@dataclass(frozen=True, slots=True, eq=False)
class Carry:
    """Move to `pose`, not below its height on the way across.

    Attributes:
        pose: where the tool goes.
        speed: [m/s].
        closure: of the hand.
    """

    pose: Pose
    speed: float
    closure: float
    name: str = "carry"
    tares: ClassVar[bool] = True

    def begin(self, inputs: PrimitiveInput, last: Setpoint) -> ActiveCarry:
        """Start from the last reference pose; where that is low, rise from where the hand is."""
        here = last.reference.pose
        lines: tuple[StraightLine, ...] = ()
        rise = float(self.pose.translation[2] - here.translation[2])
        if rise > BACK:
            level = here.rotation[:, 0] * np.array([1.0, 1.0, 0.0])
            away = inputs.pose.translation - here.translation - BACK * level / np.linalg.norm(level)
            lines = (StraightLine(here, np.array([away[0], away[1], rise]), self.speed),)
            here = lines[0].end
        turn = pin.log3(self.pose.rotation @ here.rotation.T)
        way = self.pose.translation - here.translation
        lines += (StraightLine(here, way, self.speed, rotation=turn, angular_speed=ANGULAR_SPEED),)
        return ActiveCarry(inputs, LineChain(lines), self.closure, NO_FORCE)


@dataclass(frozen=True, slots=True, eq=False)
class ActiveCarry(ActivePath):
    """A carry under way."""

    def ending(self, inputs: PrimitiveInput) -> Ending | None:
        """End when the way and the rest after it are over, if the tool got there."""
        if self.elapsed(inputs) < self.path.duration + REST_TIME:
            return None
        away = math.dist(inputs.pose.translation, self.path.lines[-1].end.translation)
        if away > TOLERANCE:
            return Ending(f"ended {1000 * away:.0f} mm away from its goal", failed=True)
        return Ending("arrived")
