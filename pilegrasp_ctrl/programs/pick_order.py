"""Orders from a bin (the paper, V-H): attempts are repeated until enough objects are in the order's crate."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..analysis.kept_objects import NOTHING_HELD
from ..config import Scenario
from ..exceptions import ArgumentError, UnreachablePoseError
from ..planning.crate import Crate
from ..planning.layout import Layout
from ..planning.strategy import Plan, tool_rotation
from ..primitives.free_motions import Carry
from ..primitives.grasp import Release
from ..primitives.primitive import Primitive
from ..primitives.retry import Composite
from ..types import Outcome, Pose
from .operator import BinState, Operator, SeeingOperator, TrueCounts

CARRY_SPEED = 0.25
"""Speed of the hand between bin and crate [m/s]; chosen."""

STOP_SHORT = 0.25
"""Distance of the fingertips from the middle of the order's crate at the release, as a share of its length [-]; chosen.

The objects roll off forward. A light ball that lands near the middle bounces out over the far wall."""

RELEASE_TIME = 2.0
"""Time for which the hand is open before the objects in the crate are counted and it moves on [s]; chosen.

A cylinder takes 1.8 s to roll off the fingers and down into the crate."""


RunPrimitives = Callable[[Sequence[Primitive | Composite], bool], list[Outcome]]
"""Function that runs primitives until one fails. The flag marks the retreat after a failure.

A retreat ignores the rims, the saturated sensor and the time limit, so that an arm on the rim can leave it."""


def delivery_pose(layout: Layout, theta: float) -> Pose:
    """Return the tool pose over the order's crate at which the hand releases.

    Args:
        layout: Layout with the order's crate.
        theta: Slope of the fingers, down away from the arm [rad].

    Raises:
        ArgumentError: The layout has no crate of an order.
    """
    crate = crates(layout)[1]
    x, y = crate.center
    yaw = math.atan2(y, x)
    point = np.array([x, y]) - STOP_SHORT * crate.inner[0] * np.array([math.cos(yaw), math.sin(yaw)])
    return Pose(np.array([*point, layout.start_height]), tool_rotation(yaw, theta))


def crates(layout: Layout) -> tuple[Crate, Crate]:
    """Return the bin and the order's crate.

    Raises:
        ArgumentError: The layout has not both.
    """
    if layout.bin is None or layout.order_crate is None:
        raise ArgumentError("an order needs a layout with a bin and the order's crate")
    return layout.bin, layout.order_crate


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
        believed_held: Number of objects that an operator without eyes believes to have held; None for one that sees.
        believed_delivered: Number of objects that it believes to have delivered.
    """

    goal: str
    held: int
    delivered: int
    reason: str
    start: float
    end: float
    believed_held: int | None = None
    believed_delivered: int | None = None

    def as_dict(self) -> dict[str, Any]:
        """Return the fields as plain JSON values, the beliefs only if the operator has any."""
        fields = {name: getattr(self, name) for name in self.__slots__}
        return {name: value for name, value in fields.items() if value is not None}


class PickOrder:
    """An order: it composes the primitives of its attempts, asks its operator, and judges by the truth.

    Attributes:
        attempts: Attempts so far.
        operator: Operator, who chooses the lines and counts.
    """

    def __init__(self, scenario: Scenario, delivery: Pose, counts: TrueCounts, operator: Operator) -> None:
        """Set the order's size and its operator.

        Args:
            scenario: Scenario with the order's size.
            delivery: Tool pose of the release over the order's crate.
            counts: True counts, by which the order is judged.
            operator: Operator.
        """
        self._count, self._max_attempts = scenario.order.count, scenario.order.max_attempts
        self._delivery, self._counts, self.operator = delivery, counts, operator
        self.attempts: list[PickAttempt] = []

    def fill(
        self, read_state: Callable[[], BinState], begin: Callable[[Plan], None], run_primitives: RunPrimitives
    ) -> tuple[list[Outcome], str | None]:
        """Run attempts until the operator takes the order for complete.

        Args:
            read_state: Function that returns the present state of the bin.
            begin: Function that prepares the loop for an attempt, before anything moves.
            run_primitives: Function that runs primitives in the loop.

        Returns:
            The outcomes of all primitives, and the reason why the order is not complete; None if it is complete.
        """
        outcomes: list[Outcome] = []
        operator, counts = self.operator, self._counts
        if isinstance(operator, SeeingOperator):
            operator.look = read_state
        while len(self.attempts) < self._max_attempts:
            before, counted_before = read_state(), operator.count_delivered()
            missing = self._count - counted_before
            try:
                line, plan, _ = operator.next_plan(before.posture)
            except UnreachablePoseError as error:
                return outcomes, str(error)
            begin(plan)
            done, held, true_held, failure = self._attempt(plan, missing, before, read_state, run_primitives)
            outcomes += done
            after, counted = read_state(), operator.count_delivered() - counted_before
            delivered = counts.delivered(after.poses) - counts.delivered(before.poses)
            reason = "" if counted else failure or "nothing of what was held reached the order's crate"
            operator.note(line, counted, done)
            beliefs = (held, counted) if operator.believes else (None, None)
            self.attempts.append(
                PickAttempt(line.name, true_held, delivered, reason, before.time, after.time, *beliefs)
            )
            if counted >= missing:
                return outcomes, self._error(counts.delivered(after.poses))
            if done[-1].name == "retreat" and done[-1].status == "failed":
                return outcomes, f"retreat: {done[-1].trigger}"
        delivered = counts.delivered(read_state().poses)
        return outcomes, f"{delivered} of {self._count} delivered after {self._max_attempts} attempts"

    def _error(self, delivered: int) -> str | None:
        """Return what is wrong with an order that its operator takes for complete."""
        if self.operator.believes and delivered != self._count:
            return f"the operator counted {self._count} or more, but {delivered} of {self._count} were delivered"
        return None

    def _attempt(
        self,
        plan: Plan,
        missing: int,
        before: BinState,
        read_state: Callable[[], BinState],
        run_primitives: RunPrimitives,
    ) -> tuple[list[Outcome], int, int, str | None]:
        """Return the outcomes, what was held after the lift, as counted and truly, and the reason of a failure."""
        operator = self.operator
        first = () if not self.attempts else (Carry(plan.start, CARRY_SPEED, plan.closure, "return"),)
        steps = (*first, *operator.weigh("empty"), *plan.primitives, *operator.weigh("lifted"))
        done = run_primitives(steps, False)
        held, true_held, failure = 0, 0, None
        if done[-1].status != "failed":
            true_held = self._counts.held(read_state(), before.poses[:, 2])
            held = operator.count_held()
            if not held:
                failure = NOTHING_HELD
            elif held > missing:
                failure = f"{held} held where {missing} were missing: dropped back"
                done += run_primitives((Release(RELEASE_TIME, "drop_back"),), False)
            else:
                delivery = Carry(self._delivery, CARRY_SPEED, 1.0, "deliver"), *operator.weigh("over_crate")
                done += run_primitives((*delivery, Release(RELEASE_TIME), *operator.weigh("released")), False)
        if done[-1].status == "failed":
            failure = f"{done[-1].name}: {done[-1].trigger}"
            done += run_primitives((Carry(plan.start, CARRY_SPEED, 0.0, "retreat"),), True)
        return done, held, true_held, failure
