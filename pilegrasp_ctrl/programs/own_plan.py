"""The program of a user's plan: a function `plan(parts) -> Plan`, named as `module:function`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..config import Scenario
from ..exceptions import ConfigurationError, PilegraspError, UnreachablePoseError
from ..planning.hand_use import HandUse
from ..planning.layout import Layout
from ..planning.push_line import PushLine
from ..planning.strategy import Plan
from ..plugins import explain, load_plugin
from ..program_traits import PLAN_PARAMETERS
from ..sections import StrategyConfig
from ..types import Array, Pose
from .program import Runner, SingleCourse, Verdict
from .shipped import plan_on_line
from .workplace import Workplace

PRIMITIVE_MEMBERS = ("name", "tares", "begin")
"""What a primitive must have."""


@dataclass(frozen=True, eq=False)
class PlanParts:
    """What a plan is made from. Lengths are in metres, angles in radians; the table's top is z = 0.

    Attributes:
        scenario: Scenario of the attempt.
        hand: Numbers of the hand: slope, preshape, closing time, outline.
        layout: Walls, push goals, and place of the arm's base.
        poses: (n, 7) poses of the objects as they are known: position and quaternion wxyz.
        object_radius: Radius of the ball around the largest object [m].
        line: Line of the shipped plan's push.
        reach: Farthest distance of the fingertips from the arm's axis that is tried [m]. The plan is made again with a
            smaller one if its end is out of reach.
    """

    scenario: Scenario
    hand: HandUse
    layout: Layout
    poses: Array
    object_radius: float
    line: PushLine
    reach: float
    _workplace: Workplace

    @property
    def strategy(self) -> StrategyConfig:
        """Keys `strategy.*` of the scenario: angles, speeds and thresholds."""
        return self.scenario.strategy

    def grasp_plan(self) -> Plan:
        """Return the shipped plan: approach, push, grasp, lift. Change it with `dataclasses.replace`."""
        return plan_on_line(self._workplace, self.line, self.reach)

    def push_plan(self) -> Plan:
        """Return the shipped plan without grasp and lift."""
        return plan_on_line(self._workplace, self.line, self.reach, grasp=False)


@dataclass(frozen=True, slots=True)
class OwnPlan:
    """A user's plan.

    Attributes:
        name: Name `module:function`.
        function: The function.
    """

    name: str
    function: Callable[[PlanParts], Plan]

    @classmethod
    def load(cls, name: str) -> OwnPlan:
        """Find the function.

        Raises:
            ConfigurationError: It cannot be found, or takes other arguments.
        """
        return cls(name, load_plugin(name, "program", PLAN_PARAMETERS, named=True).function)

    def begin(self, workplace: Workplace) -> OwnCourse:
        """Call the function, and check what it returns.

        Raises:
            ConfigurationError: The function raises, or returns something else than a plan.
            UnreachablePoseError: A pose of the plan is out of reach.
        """
        line = workplace.push_line(workplace.poses, workplace.goal)
        parts = PlanParts(
            workplace.scenario,
            workplace.hand.use,
            workplace.layout,
            workplace.poses.copy(),
            workplace.objects.bounding_radius,
            line,
            0.0,
            workplace,
        )

        def make(farthest: float) -> Plan:
            with self.explained("raised while it planned"):
                plan = self.function(replace(parts, reach=farthest))
            self._check(plan)
            return plan

        try:
            plan, posture = workplace.within_reach(make)
        except UnreachablePoseError as error:
            raise UnreachablePoseError(f"program = {self.name!r}: a pose of its plan: {error}") from None
        return OwnCourse(self, plan, posture, workplace.scenario.strategy.lift_height)

    @contextmanager
    def explained(self, what: str) -> Iterator[None]:
        """Turn what the user's code raises into one sentence.

        Raises:
            ConfigurationError: It raised.
        """
        try:
            yield
        except PilegraspError:
            raise
        except Exception as error:
            raise ConfigurationError(f"program = {self.name!r} {what}: {explain(error)}") from error

    def _check(self, plan: Any) -> None:
        wrong = _fault(plan)
        if wrong:
            raise ConfigurationError(f"program = {self.name!r} {wrong}")


class OwnCourse(SingleCourse):
    """The course of a user's plan."""

    def __init__(self, program: OwnPlan, plan: Plan, posture: Array, lift_height: float) -> None:
        """Take the program, its plan, the posture at the start (nv,) [rad], and the height of the lift [m]."""
        super().__init__(plan, posture, lift_height)
        self._program = program

    def run(self, loop: Runner) -> Verdict:
        """Run the primitives.

        Raises:
            ConfigurationError: A primitive raised.
        """
        with self._program.explained("raised while it ran"):
            return super().run(loop)


def _fault(plan: Any) -> str | None:
    """Return what is wrong with what a plan's function returned, or None."""
    if not isinstance(plan, Plan):
        return f"returned {plan!r:.80}, but it must return a pilegrasp_ctrl.Plan, as parts.grasp_plan() does"
    poses = [plan.start, *plan.waypoints, plan.end]
    if not all(isinstance(pose, Pose) for pose in poses):
        return "returned a plan whose start, waypoints or end are no pilegrasp_ctrl.Pose"
    if not plan.primitives:
        return "returned a plan without primitives; give at least one"
    for primitive in plan.primitives:
        missing = (
            [] if hasattr(primitive, "run") else [each for each in PRIMITIVE_MEMBERS if not hasattr(primitive, each)]
        )
        if missing:
            return f"returned a plan with {primitive!r:.80}, which is no primitive, because it has no {missing[0]}"
    direction = np.asarray(plan.direction)
    if direction.shape != (3,) or not np.isfinite(direction).all():
        return f"returned a plan whose direction is {plan.direction!r:.80}; give a unit vector (3,)"
    if not 0.0 <= float(plan.closure) <= 1.0:
        return f"returned a plan whose closure is {plan.closure!r:.80}; it must be between 0 and 1"
    return None
