"""The program of an order from a bin."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from ..planning.push_goal import PushGoal
from ..planning.push_line import PushLine
from ..planning.strategy import Plan
from ..primitives.guarded_motions import Approach
from ..sim.objects import objects_of
from ..types import STANDARD_GRAVITY, Array
from .blind_operator import BlindOperator
from .line_rules import rule_of, touch_distance
from .operator import Operator, SeeingOperator, TrueCounts
from .pick_order import PickAttempt, PickOrder, crates, delivery_pose
from .program import Runner, Verdict
from .shipped import plan_on_line
from .workplace import Workplace

HIGHEST_TOUCH = 0.015
"""Height of the fingertips over the floor at touch-down above which an object is under the hand [m]. Chosen: three
times the arm's deflection under the touch force."""


class OrderProgram:
    """Attempts from a bin until enough objects are in the order's crate."""

    def begin(self, workplace: Workplace) -> OrderCourse:
        """Plan the first attempt, and check that the hand reaches the crate from its start."""
        layout, scenario = workplace.layout, workplace.scenario
        members = workplace.objects.net.members if workplace.objects.net else 1
        delivery = delivery_pose(layout, workplace.hand.theta)
        counts = TrueCounts(crates(layout)[1], members, scenario.strategy.lift_height)
        if scenario.order.operator == "sees":
            seeing = _seeing(workplace, counts)
            operator: Operator = seeing
            _, plan, posture = seeing.plan_for(workplace.poses)
        else:
            operator = _blind(workplace, members)
            _, plan, posture = operator.next_plan(None)
        order = PickOrder(scenario, delivery, counts, operator)
        workplace.search.solve(delivery, posture)
        return OrderCourse(order, plan, posture)


def _blind(workplace: Workplace, members: int) -> BlindOperator:
    """Return the operator with the scenario's rule; it gets bin, hand and mass of a part, and no pose."""
    layout, scenario = workplace.layout, workplace.scenario

    def plan_line(line: PushGoal, posture: Array | None) -> tuple[Plan, Array]:
        back = touch_distance(line) - scenario.strategy.clearance
        blind = PushLine(line.anchor, back, line.yaw)
        return workplace.within_reach(lambda farthest: _guarded(plan_on_line(workplace, blind, farthest)), posture)

    models = objects_of(scenario.pile).assign_models(max(scenario.pile.count, 1))
    mass = math.fsum(model.mass for model in models) / len(models)
    weight = members * mass * -STANDARD_GRAVITY[2]
    name = scenario.order.operator
    return BlindOperator(rule_of(name), layout.goals, plan_line, weight, workplace.seed, name)


def _guarded(plan: Plan) -> Plan:
    """Return a plan whose approach fails on an object under the hand."""
    return replace(
        plan,
        primitives=tuple(
            replace(step, highest_touch=HIGHEST_TOUCH) if isinstance(step, Approach) else step
            for step in plan.primitives
        ),
    )


def _seeing(workplace: Workplace, counts: TrueCounts) -> SeeingOperator:
    layout, scenario = workplace.layout, workplace.scenario

    def plan_to(poses: Array, goal: PushGoal | None, posture: Array | None = None) -> tuple[Plan, Array]:
        line = workplace.push_line(poses, goal)
        return workplace.within_reach(lambda farthest: plan_on_line(workplace, line, farthest), posture)

    half_width = workplace.hand.use.aim_half_width
    return SeeingOperator(scenario, crates(layout)[0], layout.goals, half_width, counts, plan_to)


class OrderCourse:
    """The course of an order."""

    def __init__(self, order: PickOrder, plan: Plan, posture: Array) -> None:
        """Take the order, its first plan, and the posture at its start (nv,) [rad]."""
        self._order, self.plan, self.posture = order, plan, posture

    @property
    def attempts(self) -> Sequence[PickAttempt]:
        """Attempts so far."""
        return self._order.attempts

    def run(self, loop: Runner) -> Verdict:
        """Run attempts until the order is complete, or cannot be completed."""
        outcomes, reason = self._order.fill(loop.state, loop.begin, loop.run_primitives)
        return Verdict(outcomes, sum(pick.delivered for pick in self.attempts), reason)
