"""Orders from a bin (the paper, V-H): attempt after attempt until so many objects lie in the order's crate."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..analysis.grasp_check import are_held
from ..config import Scenario
from ..exceptions import UnreachablePoseError
from ..planning.layout import BIN_CENTER
from ..planning.push_goal import PushGoal
from ..planning.strategy import HAND_HALF_WIDTH, Plan, tool_rotation
from ..planning.walls import BIN_INNER, ORDER_CENTER, ORDER_INNER, inside
from ..primitives.free_motions import Carry
from ..primitives.grasp import Release
from ..primitives.primitive import Primitive
from ..types import Array, Outcome, Pose

CARRY_SPEED = 0.25
CARRY_HEIGHT = 0.22
"""Of the fingertips over the floor while the hand travels; the rims are at 0.16 m [m]."""
SHORT = 0.04
"""The fingertips stop this far before the middle of the order's crate; what they hold rolls off forward [m]."""
RELEASE_TIME = 2.0
"""The hand stays open for this long before it moves on, and before what it dropped is counted [s]. A cylinder takes
1.8 s to roll off the fingers and down into the crate."""

Look = Callable[[], tuple[Array, Array, Array, float]]
"""Returns the objects' poses (n, 7), the tool's position (3,) [m], the arm's posture (nv,) [rad] and the time [s]."""

RunPrimitives = Callable[[Sequence[Primitive], bool], list[Outcome]]
"""Carries out primitives until one fails. The flag says that the arm is withdrawn after a failure: what has failed is
then not looked at again, so that an arm on the rim can leave it."""

PlanTo = Callable[[Array, PushGoal, Array | None], tuple[Plan, Array]]
"""Returns the plan of an attempt at a goal and the posture at its start, from the poses (n, 7) of the objects in the
bin and the arm's present posture; raises an UnreachablePoseError."""


def delivery_pose(theta: float) -> Pose:
    """Return where the tool opens over the order's crate, the fingers sloping by `theta` [rad] away from the arm."""
    yaw = math.atan2(ORDER_CENTER[1], ORDER_CENTER[0])
    before = ORDER_CENTER - SHORT * np.array([math.cos(yaw), math.sin(yaw)])
    return Pose(np.array([*before, CARRY_HEIGHT]), tool_rotation(yaw, theta))


@dataclass(frozen=True, slots=True)
class PickAttempt:
    """One attempt of an order.

    Attributes:
        goal: what was pushed to: "wall", "corner_left" or "corner_right".
        held: objects in the hand after the lift; a net-bag counts as one.
        delivered: how many more the order's crate holds after the attempt than before it.
        reason: why none was delivered, or "".
        start: [s].
        end: [s].
    """

    goal: str
    held: int
    delivered: int
    reason: str
    start: float
    end: float

    def as_dict(self) -> dict[str, Any]:
        """Return the fields as plain JSON values."""
        return {name: getattr(self, name) for name in self.__slots__}


class PickOrder:
    """An order under way: composes the primitives of its attempts and keeps count.

    It looks at the simulated poses where the paper's operator looks into the bin: to choose wall or corner, to say
    what is in the hand, and to count what has been delivered.

    Attributes:
        attempts: what has been tried so far.
    """

    def __init__(
        self, scenario: Scenario, goals: Sequence[PushGoal], members: int, deliver: Pose, plan: PlanTo
    ) -> None:
        """Take what does not change.

        Args:
            scenario: with the order's size and the height of the lift.
            goals: in the bin, the scenario's own first.
            members: objects in a net-bag, 1 where there are none.
            deliver: where the tool opens over the order's crate.
            plan: see `PlanTo`.
        """
        self._count, self._limit = scenario.order.count, scenario.order.max_attempts
        self._lift, self._members = scenario.strategy.lift_height, members
        self._goals, self._deliver, self._plan_to = goals, deliver, plan
        self.attempts: list[PickAttempt] = []
        self._failed_lines: list[PushGoal] = []

    def next_plan(self, poses: Array, posture: Array | None = None) -> tuple[PushGoal, Plan, Array]:
        """Return the next attempt's goal, on the line of its push, its plan and the posture at its start.

        The rule: since the last delivery every goal in reach has its turn, and among those that are next the one that
        has most objects before the hand, the scenario's own among equals. A goal that is tried again is tried on
        another line where there is one, because a push that holds nothing leaves the pile nearly as it was.

        Raises:
            UnreachablePoseError: where the arm can get to none of them.
        """
        pile = poses[inside(poses[:, :3], BIN_CENTER, BIN_INNER)]
        failures = Counter(line.name for line in self._failed_lines)
        lines = [goal.best_line(pile[:, :2], HAND_HALF_WIDTH, self._failed_lines) for goal in self._goals]
        for line, _ in sorted(lines, key=lambda found: (failures[found[0].name], -found[1])):
            try:
                return line, *self._plan_to(pile, line, posture)
            except UnreachablePoseError as error:
                unreachable = error
        raise unreachable

    def delivered(self, poses: Array) -> int:
        """Return how many objects lie in the order's crate; a net-bag does where its middle does."""
        middle = poses[:, :3].reshape(-1, self._members, 3).mean(axis=1)
        return int(np.count_nonzero(inside(middle, ORDER_CENTER, ORDER_INNER)))

    def fill(
        self, look: Look, begin: Callable[[Plan], None], run_primitives: RunPrimitives
    ) -> tuple[list[Outcome], str]:
        """Carry out attempts until the order is complete.

        Args:
            look: what the operator sees.
            begin: makes the loop ready for an attempt, before anything moves.
            run_primitives: the loop.

        Returns:
            The outcomes of all primitives, and why the order is not complete, or "".
        """
        outcomes: list[Outcome] = []
        while len(self.attempts) < self._limit:
            poses, _, posture, start = look()
            have = self.delivered(poses)
            try:
                line, plan, _ = self.next_plan(poses, posture)
            except UnreachablePoseError as error:
                return outcomes, str(error)
            begin(plan)
            done, held, reason = self._attempt(plan, have, poses[:, 2], look, run_primitives)
            outcomes += done
            poses, _, _, end = look()
            gained = self.delivered(poses) - have
            reason = "" if gained else reason or "nothing of what was held reached the order's crate"
            self._failed_lines = [] if gained else [*self._failed_lines, line]
            self.attempts.append(PickAttempt(line.name, held, gained, reason, start, end))
            if have + gained >= self._count:
                return outcomes, ""
            if done[-1].name == "retreat" and done[-1].status == "failed":
                return outcomes, f"retreat: {done[-1].trigger}"
        return outcomes, f"{self.delivered(look()[0])} of {self._count} delivered after {self._limit} attempts"

    def _attempt(
        self, plan: Plan, have: int, rest_height: Array, look: Look, run_primitives: RunPrimitives
    ) -> tuple[list[Outcome], int, str]:
        """Return the outcomes, the number held after the lift, and why nothing will be delivered, or ""."""
        first = () if not self.attempts else (Carry(plan.start, CARRY_SPEED, plan.closure, "return"),)
        done = run_primitives((*first, *plan.primitives), False)
        held, reason = 0, ""
        if done[-1].status != "failed":
            poses, tool, _, _ = look()
            hanging = are_held(poses[:, :3], tool, rest_height, self._lift)
            held = int(np.count_nonzero(hanging.reshape(-1, self._members).any(axis=1)))
            if not held:
                reason = "nothing was in the hand after the lift"
            elif held > self._count - have:
                reason = f"{held} held where {self._count - have} were missing: dropped back"
                done += run_primitives((Release(RELEASE_TIME, "drop_back"),), False)
            else:
                done += run_primitives(
                    (Carry(self._deliver, CARRY_SPEED, 1.0, "deliver"), Release(RELEASE_TIME)), False
                )
        if done[-1].status == "failed":
            reason = f"{done[-1].name}: {done[-1].trigger}"
            done += run_primitives((Carry(plan.start, CARRY_SPEED, 0.0, "retreat"),), True)
        return done, held, reason
