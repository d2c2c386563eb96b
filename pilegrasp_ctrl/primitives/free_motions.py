"""Move, lift and carry: straight motions in free space that end at their goal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pinocchio as pin

from ..trajectories.straight_line import LineChain, StraightLine
from ..types import Array, Pose
from ..vectors import norm, product
from .primitive import NO_FORCE, UP, ActivePath, Ending, PrimitiveInput, Setpoint, horizontal_direction

SETTLE_TIME = 0.5
"""Time at rest after a line [s]; chosen so that a recording shows the error's decay."""

TOLERANCE = 0.05
"""Distance of the tool from its goal beyond which a motion has failed [m]; chosen."""

CARRY_REST_TIME = 0.3
"""Time at rest after a carry [s]; chosen so that an object that hangs in the hand comes to rest."""

CARRY_BACK = 0.06
"""Distance by which a hand backs off as it rises from the bin [m]; chosen so that it does not touch the rim."""

CARRY_ANGULAR_SPEED = 0.6
"""Largest angular speed of a carry [rad/s]; chosen."""


@dataclass(frozen=True, slots=True, eq=False)
class Move:
    """Follow a straight line.

    Attributes:
        displacement: (3,) Displacement of the tool [m].
        speed: Speed of the tool [m/s].
        closure: Closure of the hand.
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
    """A move that has begun."""

    def ending(self, inputs: PrimitiveInput) -> Ending | None:
        """End after the line and the rest time; fail if the tool is not at the end of the line."""
        if self.elapsed(inputs) < self.path.duration + SETTLE_TIME:
            return None
        error = self.distance_to_end(inputs)
        if error > TOLERANCE:
            return Ending(f"the line ended {1000 * error:.0f} mm away from its end", failed=True)
        return Ending("end of the line")


@dataclass(frozen=True, slots=True, eq=False)
class Lift:
    """Move up by `height` at `speed`, then wait for `hold` seconds with the hand closed.

    Attributes:
        height: Height of the lift [m].
        speed: Speed of the lift [m/s].
        hold: Waiting time at the top [s].
        back: (3,) Horizontal displacement with which the lift begins, measured from the hand [m]. The hand rises by the
            same distance meanwhile. Without it, the reference stays ahead of the hand and maintains the pressure.
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
            away = (inputs.pose.translation - start.translation + self.back) * (1.0 - UP)
            rise = min(norm(away), self.height)
            diagonal = StraightLine(start, away + rise * UP, self.speed)
            lines = (diagonal, StraightLine(diagonal.end, (self.height - rise) * UP, self.speed))
        return ActiveLift(inputs, LineChain(lines), last.closure, NO_FORCE, self)


@dataclass(frozen=True, slots=True, eq=False)
class ActiveLift(ActivePath):
    """A lift that has begun."""

    plan: Lift

    def force(self, inputs: PrimitiveInput) -> float:
        """Return the weight that the hand carries in addition to that at the start [N]."""
        return -self.force_up(inputs)

    def ending(self, inputs: PrimitiveInput) -> Ending | None:
        """End after the waiting time; fail if the hand is too low."""
        if self.elapsed(inputs) < self.path.duration + self.plan.hold:
            return None
        deficit = self.path.end.translation[2] - inputs.pose.translation[2]
        if deficit < TOLERANCE:
            return Ending("lifted")
        return Ending(f"the lift ended {1000 * deficit:.0f} mm short", failed=True)


@dataclass(frozen=True, slots=True, eq=False)
class Carry:
    """Move to `pose`; a hand below `pose` first rises to its height.

    Attributes:
        pose: Goal pose of the tool.
        speed: Speed of the tool [m/s].
        closure: Closure of the hand.
    """

    pose: Pose
    speed: float
    closure: float
    name: str = "carry"
    tares: ClassVar[bool] = True

    def begin(self, inputs: PrimitiveInput, last: Setpoint) -> ActiveCarry:
        """Start from the last reference pose; a low hand rises from its actual position and backs off."""
        here = last.reference.pose
        lines: tuple[StraightLine, ...] = ()
        rise = float(self.pose.translation[2] - here.translation[2])
        if rise > CARRY_BACK:
            away = inputs.pose.translation - here.translation - CARRY_BACK * horizontal_direction(here.rotation)
            lines = (StraightLine(here, np.array([away[0], away[1], rise]), self.speed),)
            here = lines[0].end
        turn = pin.log3(product(self.pose.rotation, here.rotation.T))
        displacement = self.pose.translation - here.translation
        lines += (StraightLine(here, displacement, self.speed, rotation=turn, angular_speed=CARRY_ANGULAR_SPEED),)
        return ActiveCarry(inputs, LineChain(lines), self.closure, NO_FORCE)


@dataclass(frozen=True, slots=True, eq=False)
class ActiveCarry(ActivePath):
    """A carry that has begun."""

    def ending(self, inputs: PrimitiveInput) -> Ending | None:
        """End after the path and the rest time; fail if the tool is not at its goal."""
        if self.elapsed(inputs) < self.path.duration + CARRY_REST_TIME:
            return None
        error = self.distance_to_end(inputs)
        if error > TOLERANCE:
            return Ending(f"ended {1000 * error:.0f} mm away from its goal", failed=True)
        return Ending("arrived")
