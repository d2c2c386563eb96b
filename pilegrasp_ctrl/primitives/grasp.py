"""Grasp, scoop and release: primitives in which the hand takes objects or lets them go."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..kernels.wrist import change_along, change_size
from ..trajectories.straight_line import LineChain, StraightLine
from ..types import Array, Pose, Reference
from .primitive import NO_FORCE, UP, ActivePath, Ending, PrimitiveInput, Setpoint, horizontal_direction

TILT_SPEED = 0.6
"""Angular speed of the scoop's tilt [rad/s]; chosen."""

TILT_REST_TIME = 0.2
"""Time at rest after the tilt [s]; chosen."""


@dataclass(frozen=True, slots=True, eq=False)
class Grasp:
    """Close the hand for `duration`, and advance along the push at a speed that falls to zero at F_grasp.

    The authors' arm maintains the pressure because it is soft. At 17 N its reference is about 0.1 m ahead of it, and
    stays there while the fingers curl and yield. A stiffer arm has to follow the fingers.

    Attributes:
        duration: Closing time of the hand [s].
        direction: (3,) Unit vector of the push in the world.
        speed: |v_hand| of the push [m/s].
        grasp_force: F_grasp [N].
        advance: Longest distance that the reference advances or retreats [m].
        start_force: Force against the push at the start [N]; F_grasp if absent.
    """

    duration: float
    direction: Array
    speed: float
    grasp_force: float
    advance: float
    start_force: float | None = None
    name: str = "grasp"
    tares: ClassVar[bool] = False

    def begin(self, inputs: PrimitiveInput, last: Setpoint) -> ActiveGrasp:
        """Start from the last reference pose, at F_grasp."""
        return ActiveGrasp(self, inputs, last.reference.pose)


@dataclass(slots=True, eq=False)
class ActiveGrasp:
    """A grasp that has begun. It remembers how far it has advanced."""

    plan: Grasp
    start: PrimitiveInput
    start_pose: Pose
    _advanced: float = 0.0
    _time: float | None = None

    def setpoint(self, inputs: PrimitiveInput) -> Setpoint:
        """Advance for the time since the last call, and close the hand."""
        plan = self.plan
        speed = plan.speed * min(max(1.0 - self.pressure(inputs) / plan.grasp_force, -1.0), 1.0)
        wanted = self._advanced + speed * (inputs.time - (self.start.time if self._time is None else self._time))
        self._time = inputs.time
        self._advanced = min(max(wanted, -plan.advance), plan.advance)
        twist, rest, start = np.zeros(6), np.zeros(6), self.start_pose
        if self._advanced == wanted:
            twist[:3] = speed * plan.direction
        pose = Pose.trusted(start.translation + self._advanced * plan.direction, start.rotation)
        return Setpoint(Reference.trusted(pose, twist, rest), 1.0)

    def pressure(self, inputs: PrimitiveInput) -> float:
        """Return the force against the push [N]; at the start it counts as `start_force`, or else as F_grasp."""
        begun = self.plan.grasp_force if self.plan.start_force is None else self.plan.start_force
        return begun - change_along(inputs.wrench, self.start.wrench, self.plan.direction)

    def force(self, inputs: PrimitiveInput) -> float:
        """Return the magnitude of the force change [N]."""
        return change_size(inputs.wrench, self.start.wrench)

    def ending(self, inputs: PrimitiveInput) -> Ending | None:
        """End after the closing time, because the hand has no sensor."""
        return Ending("closed") if inputs.time - self.start.time >= self.plan.duration else None


@dataclass(frozen=True, slots=True)
class Scoop:
    """Tilt back by `angle` about the heel: the grasp of a shovel.

    Attributes:
        angle: Angle of the tilt [rad].
        heel: Distance from the leading edge to the heel [m].
        slope: Slope of the shovel's floor before the tilt [rad].
    """

    angle: float
    heel: float
    slope: float
    name: str = "grasp"
    tares: ClassVar[bool] = False

    def begin(self, inputs: PrimitiveInput, last: Setpoint) -> ActiveScoop:
        """Start from the last reference pose.

        The leading edge follows the chord of its arc about the heel, so that the heel is not pressed into the support.
        """
        here = last.reference.pose
        before, after = self.slope, self.slope - self.angle
        forward = self.heel * (math.cos(after) - math.cos(before))
        upward = self.heel * (math.sin(before) - math.sin(after))
        displacement = forward * horizontal_direction(here.rotation) + upward * UP
        turn = -self.angle * here.rotation[:, 1]
        line = StraightLine(here, displacement, 1.0, rotation=turn, angular_speed=TILT_SPEED)
        return ActiveScoop(inputs, LineChain((line,)), last.closure, NO_FORCE)


@dataclass(frozen=True, slots=True, eq=False)
class ActiveScoop(ActivePath):
    """A scoop that has begun."""

    def ending(self, inputs: PrimitiveInput) -> Ending | None:
        """End after the tilt and the rest time."""
        return Ending("tilted back") if self.elapsed(inputs) >= self.path.duration + TILT_REST_TIME else None


@dataclass(frozen=True, slots=True)
class Release:
    """Stay and keep the hand open for `duration`; the objects roll off the sloping fingers.

    Attributes:
        duration: Time for which the hand is open [s].
    """

    duration: float
    name: str = "release"
    tares: ClassVar[bool] = True

    def begin(self, inputs: PrimitiveInput, last: Setpoint) -> ActiveRelease:
        """Stay at the last reference pose."""
        rest = StraightLine(last.reference.pose, np.zeros(3), 1.0)
        return ActiveRelease(inputs, LineChain((rest,)), 0.0, NO_FORCE, self)


@dataclass(frozen=True, slots=True, eq=False)
class ActiveRelease(ActivePath):
    """A release that has begun."""

    plan: Release

    def ending(self, inputs: PrimitiveInput) -> Ending | None:
        """End after `duration`, because the hand has no sensor."""
        return Ending("opened") if self.elapsed(inputs) >= self.plan.duration else None
