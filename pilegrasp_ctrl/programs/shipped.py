"""The shipped programs that run one plan: grasp and push at a pile, and a line in free space."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..planning.push_line import PushLine
from ..planning.strategy import Plan, plan_attempt, plan_line
from .program import SingleCourse
from .workplace import Workplace


@dataclass(frozen=True, slots=True)
class PileProgram:
    """Approach and push; then grasp and lift.

    Attributes:
        grasp: Whether grasp and lift follow the push.
    """

    grasp: bool

    def begin(self, workplace: Workplace) -> SingleCourse:
        """Plan a push to the support behind the pile, or to the goal in a bin."""
        line = workplace.push_line(workplace.poses, workplace.goal)
        found = workplace.within_reach(lambda farthest: plan_on_line(workplace, line, farthest, self.grasp))
        return SingleCourse(*found, workplace.scenario.strategy.lift_height)


def plan_on_line(workplace: Workplace, line: PushLine, farthest: float, grasp: bool = True) -> Plan:
    """Return the plan of a push along a line, as far as `farthest` from the arm's axis [m]."""
    return plan_attempt(
        workplace.scenario.strategy,
        workplace.hand.use,
        line.point,
        line.extent,
        farthest,
        grasp=grasp,
        yaw=line.yaw,
        base_position=np.array(workplace.layout.base_position),
        start_height=workplace.layout.start_height,
    )


class LineProgram:
    """A straight line in free space, without the pile."""

    def begin(self, workplace: Workplace) -> SingleCourse:
        """Plan the line of the scenario."""
        plan = plan_line(workplace.scenario.line, workplace.hand.use)
        return SingleCourse(*workplace.within_reach(lambda farthest: plan), workplace.scenario.strategy.lift_height)
