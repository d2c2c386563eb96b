"""Orders from a bin (the paper, V-H): attempts are repeated until enough objects are in the order's crate."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..analysis.kept_objects import NOTHING_HELD, are_held
from ..config import Scenario
from ..exceptions import UnreachablePoseError
from ..planning.layout import BIN_CENTER
from ..planning.push_goal import PushGoal
from ..planning.strategy import HAND_HALF_WIDTH, START_HEIGHT, Plan, tool_rotation
from ..planning.walls import BIN_INNER, ORDER_CENTER, ORDER_INNER, are_inside
from ..primitives.free_motions import Carry
from ..primitives.grasp import Release
from ..primitives.primitive import Primitive
from ..types import Array, Outcome, Pose

CARRY_SPEED = 0.25
"""Speed of the hand between bin and crate [m/s]; chosen."""

STOP_SHORT = 0.04
"""Distance of the fingertips from the middle of the order's crate at the release [m]; chosen.

The objects roll off forward."""

RELEASE_TIME = 2.0
"""Time for which the hand is open before the objects in the crate are counted and it moves on [s]; chosen.

A cylinder takes 1.8 s to roll off the fingers and down into the crate."""


class BinState(NamedTuple):
    """State on which the next step of an order depends.

    Attributes:
        poses: (n, 7) object poses: position [m] and quaternion wxyz.
        tool_position: (3,) position of the tool [m].
        posture: (nv,) joint angles of the arm [rad].
        time: Time [s].
    """

    poses: Array
    tool_position: Array
    posture: Array
    time: float


RunPrimitives = Callable[[Sequence[Primitive], bool], list[Outcome]]
"""Function that runs primitives until one fails. The flag marks the retreat after a failure.

A retreat ignores the rims, the saturated sensor and the time limit, so that an arm on the rim can leave it."""

PlanPush = Callable[[Array, PushGoal, Array | None], tuple[Plan, Array]]
"""Function that returns the plan of an attempt at a goal and the posture at its start.

The arguments are the poses (n, 7) of the objects in the bin, the goal, and the arm's present posture. The function
raises an UnreachablePoseError if a pose is out of reach."""


def delivery_pose(theta: float) -> Pose:
    """Return the tool pose over the order's crate at which the hand releases.

    Args:
        theta: Slope of the fingers, down away from the arm [rad].
    """
    yaw = math.atan2(ORDER_CENTER[1], ORDER_CENTER[0])
    point = ORDER_CENTER - STOP_SHORT * np.array([math.cos(yaw), math.sin(yaw)])
    return Pose(np.array([*point, START_HEIGHT]), tool_rotation(yaw, theta))


@dataclass(frozen=True, slots=True)
class PickAttempt:
    """One attempt of an order.

    Attributes:
        goal: Goal of the push: "wall", "corner_left" or "corner_right".
        held: Number of objects in the hand after the lift; a net-bag counts as one.
        delivered: Number of objects that the attempt added to the order's crate.
        reason: Reason for no delivery; "" after a delivery.
        start: Start time [s].
        end: End time [s].
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
    """An order: it composes the primitives of its attempts and counts the deliveries.

    It uses the simulated poses in place of the paper's operator, who looks into the bin. They decide between wall and
    corners, the objects in the hand, and the number of delivered objects.

    Attributes:
        attempts: Attempts so far.
    """

    def __init__(
        self, scenario: Scenario, goals: Sequence[PushGoal], members: int, delivery: Pose, plan_push: PlanPush
    ) -> None:
        """Set the order's size, goals and planner.

        Args:
            scenario: Scenario with the order's size and the height of the lift.
            goals: Push goals in the bin, the scenario's own first.
            members: Number of objects in a net-bag; 1 without net-bags.
            delivery: Tool pose of the release over the order's crate.
            plan_push: Planner of an attempt.
        """
        self._count, self._max_attempts = scenario.order.count, scenario.order.max_attempts
        self._lift_height, self._members = scenario.strategy.lift_height, members
        self._goals, self._delivery, self._plan_push = goals, delivery, plan_push
        self.attempts: list[PickAttempt] = []
        self._failed_lines: list[PushGoal] = []

    def next_plan(self, poses: Array, posture: Array | None = None) -> tuple[PushGoal, Plan, Array]:
        """Return the next attempt's goal, moved onto its push line, its plan and the posture at its start.

        After a delivery, every goal in reach is tried once before a goal is tried again. Among the goals with the
        fewest tries, the one with most objects before the hand is chosen, and among equals the scenario's own. A goal
        is tried again on another line if there is one, because a push that holds nothing hardly changes the pile.

        Args:
            poses: (n, 7) object poses.
            posture: (nv,) present joint angles of the arm [rad].

        Raises:
            UnreachablePoseError: No goal is in reach.
        """
        pile = poses[are_inside(poses[:, :3], BIN_CENTER, BIN_INNER)]
        failures = Counter(line.name for line in self._failed_lines)
        lines = [goal.best_line(pile[:, :2], HAND_HALF_WIDTH, self._failed_lines) for goal in self._goals]
        for line, _ in sorted(lines, key=lambda found: (failures[found[0].name], -found[1])):
            try:
                return line, *self._plan_push(pile, line, posture)
            except UnreachablePoseError as error:
                unreachable = error
        raise unreachable

    def count_delivered(self, poses: Array) -> int:
        """Return the number of objects in the order's crate. A net-bag counts as one; its middle decides."""
        middle = poses[:, :3].reshape(-1, self._members, 3).mean(axis=1)
        return int(np.count_nonzero(are_inside(middle, ORDER_CENTER, ORDER_INNER)))

    def fill(
        self, read_state: Callable[[], BinState], begin: Callable[[Plan], None], run_primitives: RunPrimitives
    ) -> tuple[list[Outcome], str | None]:
        """Run attempts until the order is complete.

        Args:
            read_state: Function that returns the present state of the bin.
            begin: Function that prepares the loop for an attempt, before anything moves.
            run_primitives: Function that runs primitives in the loop.

        Returns:
            The outcomes of all primitives, and the reason why the order is not complete; None if it is complete.
        """
        outcomes: list[Outcome] = []
        while len(self.attempts) < self._max_attempts:
            before = read_state()
            delivered_before = self.count_delivered(before.poses)
            try:
                line, plan, _ = self.next_plan(before.poses, before.posture)
            except UnreachablePoseError as error:
                return outcomes, str(error)
            begin(plan)
            missing = self._count - delivered_before
            done, held, failure = self._attempt(plan, missing, before.poses[:, 2], read_state, run_primitives)
            outcomes += done
            after = read_state()
            delivered = self.count_delivered(after.poses) - delivered_before
            reason = "" if delivered else failure or "nothing of what was held reached the order's crate"
            self._failed_lines = [] if delivered else [*self._failed_lines, line]
            self.attempts.append(PickAttempt(line.name, held, delivered, reason, before.time, after.time))
            if delivered >= missing:
                return outcomes, None
            if done[-1].name == "retreat" and done[-1].status == "failed":
                return outcomes, f"retreat: {done[-1].trigger}"
        delivered = self.count_delivered(read_state().poses)
        return outcomes, f"{delivered} of {self._count} delivered after {self._max_attempts} attempts"

    def _attempt(
        self,
        plan: Plan,
        missing: int,
        rest_height: Array,
        read_state: Callable[[], BinState],
        run_primitives: RunPrimitives,
    ) -> tuple[list[Outcome], int, str | None]:
        """Return the outcomes, the number of objects held after the lift, and the reason of a failure, if any."""
        first = () if not self.attempts else (Carry(plan.start, CARRY_SPEED, plan.closure, "return"),)
        done = run_primitives((*first, *plan.primitives), False)
        held, failure = 0, None
        if done[-1].status != "failed":
            state = read_state()
            hanging = are_held(state.poses[:, :3], state.tool_position, rest_height, self._lift_height)
            held = int(np.count_nonzero(hanging.reshape(-1, self._members).any(axis=1)))
            if not held:
                failure = NOTHING_HELD
            elif held > missing:
                failure = f"{held} held where {missing} were missing: dropped back"
                done += run_primitives((Release(RELEASE_TIME, "drop_back"),), False)
            else:
                delivery = Carry(self._delivery, CARRY_SPEED, 1.0, "deliver"), Release(RELEASE_TIME)
                done += run_primitives(delivery, False)
        if done[-1].status == "failed":
            failure = f"{done[-1].name}: {done[-1].trigger}"
            done += run_primitives((Carry(plan.start, CARRY_SPEED, 0.0, "retreat"),), True)
        return done, held, failure
