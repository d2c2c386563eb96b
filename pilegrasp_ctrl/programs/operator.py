"""The operator of an order: who chooses the push lines, and counts what the hand holds and delivers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from typing import ClassVar, NamedTuple, Protocol

import numpy as np

from ..analysis.kept_objects import are_held
from ..config import Scenario
from ..exceptions import UnreachablePoseError
from ..planning.crate import Crate
from ..planning.push_goal import PushGoal
from ..planning.strategy import Plan
from ..primitives.primitive import Primitive
from ..types import Array, Outcome
from .workplace import believed_poses


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


PlanPush = Callable[[Array, PushGoal, Array | None], tuple[Plan, Array]]
"""Function that returns the plan of an attempt at a goal and the posture at its start.

The arguments are the poses (n, 7) of the objects in the bin, the goal, and the arm's present posture. The function
raises an UnreachablePoseError if a pose is out of reach."""


class Operator(Protocol):
    """Who decides in an order. `PickOrder` composes the attempts; the truth judges them.

    The loop calls `next_plan`, then runs the primitives of `weigh` at their moments, and asks for the counts.
    """

    believes: ClassVar[bool]
    """Whether its counts are beliefs, which are recorded beside the truth."""

    def next_plan(self, posture: Array | None) -> tuple[PushGoal, Plan, Array]:
        """Return the line of the next attempt, its plan, and the posture (nv,) at its start [rad].

        Raises:
            UnreachablePoseError: No line is in reach.
        """

    def weigh(self, moment: str) -> tuple[Primitive, ...]:
        """Return what it does at a moment: "empty" before the approach, "lifted", "over_crate", or "released"."""

    def count_held(self) -> int:
        """Return how many objects the hand holds after the lift."""

    def count_delivered(self) -> int:
        """Return how many objects are in the order's crate."""

    def note(self, line: PushGoal, delivered: int, outcomes: Sequence[Outcome]) -> None:
        """Learn from an attempt: its line, what it delivered as the operator believes, and its outcomes."""


class TrueCounts:
    """Counts of objects by their true poses.

    A net-bag of several objects counts as one; its middle decides whether it is in a crate.
    """

    def __init__(self, crate: Crate, members: int, lift_height: float) -> None:
        """Take the order's crate, the number of objects in a net-bag, 1 without any, and the height of the lift [m]."""
        self._crate, self._members, self._lift_height = crate, members, lift_height

    def delivered(self, poses: Array) -> int:
        """Return the number of objects with `poses` (n, 7) in the order's crate."""
        middle = poses[:, :3].reshape(-1, self._members, 3).mean(axis=1)
        return int(np.count_nonzero(self._crate.are_inside(middle)))

    def held(self, state: BinState, rest_height: Array) -> int:
        """Return the number of objects that have come up with the hand from their heights (n,) before [m]."""
        hanging = are_held(state.poses[:, :3], state.tool_position, rest_height, self._lift_height)
        return int(np.count_nonzero(hanging.reshape(-1, self._members).any(axis=1)))


class SeeingOperator:
    """The operator that sees every pose, as the paper's operator who looks into the bin.

    After a delivery, every goal in reach is tried once before a goal is tried again. Among the goals with the fewest
    tries, the one with most objects before the hand is chosen, and among equals the scenario's own. A goal is tried
    again on another line if there is one, because a push that holds nothing hardly changes the pile.
    """

    believes: ClassVar[bool] = False

    def __init__(
        self,
        scenario: Scenario,
        bin_crate: Crate,
        goals: Sequence[PushGoal],
        half_width: float,
        counts: TrueCounts,
        plan_push: PlanPush,
    ) -> None:
        """Take the scenario, the bin, its goals, half the width of a push line [m], the counts and the planner."""
        self._known, self._bin, self._goals, self._half_width = scenario.known, bin_crate, goals, half_width
        self._counts, self._plan_push = counts, plan_push
        self._failed_lines: list[PushGoal] = []
        self.look: Callable[[], BinState] | None = None

    def _state(self) -> BinState:
        if self.look is None:
            raise UnreachablePoseError("the operator has not begun to look into the bin")
        return self.look()

    def next_plan(self, posture: Array | None) -> tuple[PushGoal, Plan, Array]:
        """Look into the bin, and plan."""
        poses = self._state().poses
        self._rest_height = poses[:, 2]
        return self.plan_for(believed_poses(self._known, poses), posture)

    def plan_for(self, poses: Array, posture: Array | None = None) -> tuple[PushGoal, Plan, Array]:
        """Return line, plan and posture for objects at poses (n, 7), as they are believed.

        Raises:
            UnreachablePoseError: No goal is in reach.
        """
        pile = poses[self._bin.are_inside(poses[:, :3])]
        failures = Counter(line.name for line in self._failed_lines)
        lines = [goal.best_line(pile[:, :2], self._half_width, self._failed_lines) for goal in self._goals]
        for line, _ in sorted(lines, key=lambda found: (failures[found[0].name], -found[1])):
            try:
                return line, *self._plan_push(pile, line, posture)
            except UnreachablePoseError as error:
                unreachable = error
        raise unreachable

    def weigh(self, moment: str) -> tuple[Primitive, ...]:
        """Do nothing: it sees."""
        return ()

    def count_held(self) -> int:
        """Count the objects in the hand by their poses."""
        return self._counts.held(self._state(), self._rest_height)

    def count_delivered(self) -> int:
        """Count the objects in the crate by their poses."""
        return self._counts.delivered(self._state().poses)

    def note(self, line: PushGoal, delivered: int, outcomes: Sequence[Outcome]) -> None:
        """Remember the lines that failed since the last delivery."""
        self._failed_lines = [] if delivered else [*self._failed_lines, line]
