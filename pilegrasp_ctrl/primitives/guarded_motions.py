"""Approach and push: motions toward a contact that end when the wrist sensor feels it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..kernels.wrist import change_along, change_size
from ..trajectories.straight_line import LineChain, StraightLine
from ..types import Array, Pose
from .primitive import NO_FORCE, OVERTIME, ActivePath, Ending, PrimitiveInput, Setpoint
from .push_endings import ActivePushEnding, PushEnding

SEARCH_DEPTH = 0.05
"""Depth below the expected surface at which the descent fails [m]; chosen."""

COLLISION_FACTOR = 5.0
"""Force in free space that counts as a collision, as a multiple of the touch force [-]; chosen."""

SINK_SPEED = 0.04
"""Speed of the reference as it sinks to the press depth [m/s]; chosen."""


@dataclass(frozen=True, slots=True)
class Approach:
    """Move to `pre_grasp`, then down until the normal force exceeds `touch_force`.

    Attributes:
        pre_grasp: Tool pose above the point of touch-down.
        height: Height of the pre-grasp pose above the surface [m].
        speed: Speed of the free-space line [m/s].
        touch_speed: Speed of the descent [m/s].
        touch_force: Normal force at which the descent ends, relative to the start [N].
        closure: Closure of the preshaped hand, in [0, 1].
        highest_touch: Largest height over the surface of a touch-down [m]; a higher one is a failure.
    """

    pre_grasp: Pose
    height: float
    speed: float
    touch_speed: float
    touch_force: float
    closure: float
    highest_touch: float = math.inf
    name: str = "approach"
    tares: ClassVar[bool] = True

    def begin(self, inputs: PrimitiveInput, last: Setpoint) -> ActiveApproach:
        """Start from the last reference pose."""
        start = last.reference.pose
        across = StraightLine(start, self.pre_grasp.translation - start.translation, self.speed)
        down = StraightLine(across.end, np.array([0.0, 0.0, -(self.height + SEARCH_DEPTH)]), self.touch_speed)
        return ActiveApproach(inputs, LineChain((across, down)), self.closure, NO_FORCE, self)


@dataclass(frozen=True, slots=True, eq=False)
class ActiveApproach(ActivePath):
    """An approach that has begun."""

    plan: Approach

    def force(self, inputs: PrimitiveInput) -> float:
        """Return the normal force of the surface [N]."""
        return self.force_up(inputs)

    def ending(self, inputs: PrimitiveInput) -> Ending | None:
        """End at the surface. A contact before the descent is a collision."""
        elapsed = self.elapsed(inputs)
        if elapsed < self.path.lines[0].duration:
            force = change_size(inputs.wrench, self.start.wrench)
            collides = force > COLLISION_FACTOR * self.plan.touch_force
            return Ending("collision in free space", failed=True) if collides else None
        if self.force(inputs) > self.plan.touch_force:
            surface = self.plan.pre_grasp.translation[2] - self.plan.height
            high = float(inputs.pose.translation[2]) - surface
            if high > self.plan.highest_touch:
                return Ending(f"an object is under the hand, {1000 * high:.0f} mm over the surface", failed=True)
            return Ending("surface contact")
        if elapsed > self.path.duration + OVERTIME:
            return Ending("travel limit: no surface", failed=True)
        return None


@dataclass(frozen=True, slots=True, eq=False)
class Push:
    """Slide along `direction` at `speed` until the force along the push reaches F_grasp.

    Attributes:
        direction: (3,) Unit vector of the push in the world.
        speed: Speed of the push, |v_hand| [m/s].
        grasp_force: Force F_grasp along the push, relative to the start [N].
        travel: Longest distance of the push [m].
        press_depth: Depth of the reference below touch-down, which keeps a soft hand in contact with the support [m].
        normal_force: Desired force on the support, for a hand that is force-controlled [N].
        closure: Closure of the preshaped hand, in [0, 1].
        endings: Events that end the push before F_grasp.
    """

    direction: Array
    speed: float
    grasp_force: float
    travel: float
    press_depth: float
    normal_force: float
    closure: float
    endings: tuple[PushEnding, ...] = ()
    name: str = "push"
    tares: ClassVar[bool] = True

    def begin(self, inputs: PrimitiveInput, last: Setpoint) -> ActivePush:
        """Continue from the last reference pose; the press depth is measured from the actual height of the hand."""
        reference = last.reference.pose
        sink = inputs.pose.translation[2] - self.press_depth - reference.translation[2]
        down = StraightLine(reference, np.array([0.0, 0.0, sink]), SINK_SPEED)
        along = StraightLine(down.end, self.travel * np.asarray(self.direction), self.speed)
        desired_force = np.array([0.0, 0.0, -self.normal_force, 0.0, 0.0, 0.0])
        watched = tuple(ending.begin() for ending in self.endings)
        return ActivePush(inputs, LineChain((down, along)), self.closure, desired_force, self, watched)


@dataclass(frozen=True, slots=True, eq=False)
class ActivePush(ActivePath):
    """A push that has begun."""

    plan: Push
    watched: tuple[ActivePushEnding, ...] = ()

    def force(self, inputs: PrimitiveInput) -> float:
        """Return the force against the push [N]."""
        return -change_along(inputs.wrench, self.start.wrench, self.plan.direction)

    def ending(self, inputs: PrimitiveInput) -> Ending | None:
        """End at F_grasp, or fail at the end of the travel."""
        if self.force(inputs) >= self.plan.grasp_force:
            return Ending("grasp force")
        for event in self.watched:
            if ending := event.ending(inputs):
                return ending
        if self.elapsed(inputs) > self.path.duration + OVERTIME:
            return Ending("travel limit: the force along the push never reached F_grasp", failed=True)
        return None
