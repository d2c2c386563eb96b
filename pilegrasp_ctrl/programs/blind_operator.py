"""The operator that does not see: it knows bin, hand and part, and has the wrist sensor alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, ClassVar

import numpy as np

from ..exceptions import ConfigurationError, UnreachablePoseError
from ..planning.push_goal import PushGoal
from ..planning.strategy import Plan
from ..plugins import explain
from ..primitives.primitive import Primitive
from ..primitives.weigh import Weigh
from ..types import Array, Outcome
from .line_rules import Rule, Told, fixed_lines

RANDOM_STREAM = 0xB1
"""Number that sets the generator of a rule apart from those of pile and sensor, which have the seed alone."""

PlanLine = Callable[[PushGoal, Array | None], tuple[Plan, Array]]
"""Function from a line and the arm's posture to the plan of an attempt and the posture at its start."""


class BlindOperator:
    """An operator without eyes. No pose of an object reaches it.

    It weighs the empty hand before the approach and the closed one after the lift. The difference over the weight of a
    part, rounded, is what it holds. Over the order's crate it weighs before and after the release; what is gone was
    delivered. The error of the tool's mass cancels in each pair of readings; drift between the two does not.
    """

    believes: ClassVar[bool] = True

    def __init__(
        self, rule: Rule, goals: Sequence[PushGoal], plan_line: PlanLine, weight: float, seed: int, name: str = ""
    ) -> None:
        """Take the rule.

        Args:
            rule: Rule that chooses among the lines.
            goals: Push goals of the bin.
            plan_line: Planner of an attempt along a line.
            weight: Weight of one part, a net-bag as a whole [N].
            seed: Seed of the rule's random numbers.
            name: Name of a user's rule, for errors.
        """
        self.lines = fixed_lines(goals)
        self._rule, self._plan_line, self._weight, self._name = rule, plan_line, weight, name
        self._random = np.random.default_rng([seed, RANDOM_STREAM])
        self._told: list[Told] = []
        self._readings: dict[str, float] = {}
        self._delivered, self._line = 0, 0
        self._chosen = False
        self._unreachable: set[int] = set()

    def next_plan(self, posture: Array | None) -> tuple[PushGoal, Plan, Array]:
        """Ask the rule for a line, once an attempt. A line out of reach is left out from then on."""
        self._readings = {}
        while True:
            usable = [place for place in range(len(self.lines)) if place not in self._unreachable]
            if not self._chosen or self._line in self._unreachable:
                self._line = usable[self._asked([self.lines[place] for place in usable], usable)]
            self._chosen = True
            try:
                return self.lines[self._line], *self._plan_line(self.lines[self._line], posture)
            except UnreachablePoseError:
                self._unreachable.add(self._line)
                if len(usable) == 1:
                    raise

    def _asked(self, lines: list[PushGoal], usable: list[int]) -> int:
        told = [each._replace(line=usable.index(each.line)) for each in self._told if each.line in usable]
        try:
            answer: Any = self._rule(lines, told, self._random)
        except Exception as error:
            raise ConfigurationError(f"order.operator = {self._name!r:.80} raised {explain(error)}") from error
        if isinstance(answer, bool) or not isinstance(answer, int | np.integer) or not 0 <= answer < len(lines):
            raise ConfigurationError(
                f"order.operator = {self._name!r:.80} returned {answer!r:.40}; the index of one of {len(lines)} lines "
                "is expected"
            )
        return int(answer)

    def weigh(self, moment: str) -> tuple[Primitive, ...]:
        """Weigh at every moment."""
        return (Weigh(partial(self._readings.__setitem__, moment)),)

    def _count(self, loaded: str, empty: str) -> int:
        """Return the number of parts between two readings."""
        if not {loaded, empty} <= self._readings.keys():
            return 0
        return max(0, round((self._readings[empty] - self._readings[loaded]) / self._weight))

    def count_held(self) -> int:
        """Return the difference between the empty and the closed hand, in parts."""
        return self._count("lifted", "empty")

    def count_delivered(self) -> int:
        """Return the parts of all releases over the crate."""
        return self._delivered + self._count("over_crate", "released")

    def note(self, line: PushGoal, delivered: int, outcomes: Sequence[Outcome]) -> None:
        """Remember the attempt."""
        self._delivered, self._readings, self._chosen = self.count_delivered(), {}, False
        pushes = [outcome for outcome in outcomes if outcome.name == "push"]
        pushed = any(outcome.status == "ended" for outcome in pushes)
        self._told.append(Told(self._line, delivered, pushed, max((each.peak_force for each in pushes), default=0.0)))
