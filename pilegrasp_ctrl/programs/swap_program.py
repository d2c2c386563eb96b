"""Two hands at one pile: one pushes until it feels F_grasp, and another one takes the pile as it lies and closes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from ..planning.strategy import Plan, plan_attempt
from ..primitives.primitive import ActivePrimitive, Ending, Primitive, PrimitiveInput, Setpoint
from ..sim.hand import Hand
from ..types import Array
from .pick_order import PickAttempt
from .program import Runner, SingleCourse, Verdict
from .shipped import PileProgram
from .workplace import Workplace, believed_poses

FOLLOW_UP = 0.06
"""Longest distance that the second hand goes on beyond the place where the first one stopped [m]; chosen.

A soft hand must go on until it presses as hard as a rigid one did. A grasp may advance as far while fingers yield."""


@dataclass(frozen=True, eq=False)
class TakeOver:
    """A push that ends at the end of its travel, too, without a failure.

    Attributes:
        push: The push.
    """

    push: Primitive
    name: str = "take_over"
    tares: ClassVar[bool] = True

    def begin(self, inputs: PrimitiveInput, last: Setpoint) -> ActiveTakeOver:
        """Begin the push."""
        return ActiveTakeOver(self.push.begin(inputs, last))


@dataclass(frozen=True, slots=True, eq=False)
class ActiveTakeOver:
    """A push that has begun."""

    push: ActivePrimitive

    def setpoint(self, inputs: PrimitiveInput) -> Setpoint:
        """Return that of the push."""
        return self.push.setpoint(inputs)

    def force(self, inputs: PrimitiveInput) -> float:
        """Return that of the push [N]."""
        return self.push.force(inputs)

    def ending(self, inputs: PrimitiveInput) -> Ending | None:
        """End at F_grasp, or where the travel ends."""
        ending = self.push.ending(inputs)
        return Ending("as far as it may go on") if ending is not None and ending.failed else ending


class SwapProgram:
    """`strategy.pushing_hand` pushes, then `hand` closes where it stopped.

    The null model of the hand's push: a plate as wide as the hand herds the same pile. The objects keep their poses and
    lose their motion, because exchanging hands takes time. The second hand comes down `strategy.clearance` behind the
    place where the first one stopped. It pushes until it feels F_grasp, but at most `FOLLOW_UP` beyond that place. Then
    it closes in any case, and lifts.
    """

    def begin(self, workplace: Workplace) -> SwapCourse:
        """Plan the push of the first hand."""
        push = PileProgram(grasp=False).begin(workplace)
        return SwapCourse(workplace, push)


class SwapCourse:
    """The course of two hands."""

    attempts: Sequence[PickAttempt] = ()

    def __init__(self, workplace: Workplace, push: SingleCourse) -> None:
        """Take the workplace of the first hand and its planned push."""
        self._workplace, self._push = workplace, push
        self.plan, self.posture = push.plan, push.posture

    def run(self, loop: Runner) -> Verdict:
        """Push, exchange the hands, close and lift.

        Raises:
            UnreachablePoseError: The second hand cannot reach the pile from the same place.
        """
        pushed = self._push.run(loop)
        if pushed.reason is not None:
            return pushed
        scenario = self._workplace.scenario
        stop, poses = loop.tool().translation[:2], loop.state().poses
        second = self._workplace.with_hand(
            Hand.load(scenario.hand, scenario.hand_model), believed_poses(scenario.known, poses)
        )
        plan, posture = second.within_reach(lambda farthest: self._plan(second, stop, farthest))
        loop.exchange(second.make_station(second, posture, poses), plan)
        outcomes, grasped, reason = SingleCourse(plan, posture, scenario.strategy.lift_height).run(loop)
        return Verdict([*pushed.outcomes, *outcomes], grasped, reason)

    def _plan(self, second: Workplace, stop: Array, farthest: float) -> Plan:
        """Return the plan of the second hand, whose push ends soon after the point `stop` (2,) [m]."""
        strategy, direction = second.scenario.strategy, self._push.plan.direction
        yaw = math.atan2(direction[1], direction[0]) - math.radians(strategy.alpha_deg)
        base = np.array(second.layout.base_position)
        plan = plan_attempt(strategy, second.hand.use, stop, 0.0, farthest, yaw=yaw, base_position=base)
        approach, push, *rest = plan.primitives
        travel = strategy.clearance + FOLLOW_UP
        end = plan.waypoints[-1].moved(travel * direction)
        follow: Any = replace(push, travel=travel)  # type: ignore[type-var]
        return replace(plan, primitives=(approach, TakeOver(follow), *rest), end=end)
