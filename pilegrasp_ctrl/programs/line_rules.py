"""Rules for an order without seeing: fixed lines in a bin, and which of them is pushed along next.

A rule is a function of the lines, of what the wrist told of earlier attempts, and of random numbers. A user's own rule
`module:function` has the same parameters.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..planning.push_goal import PushGoal
from ..plugins import is_plugin, load_plugin
from ..program_traits import RULE_PARAMETERS
from ..types import Array

SPACING = 0.04
"""Largest distance between two lines to one wall or corner [m]; chosen, below the width of a hand."""

FARTHEST = 0.35
"""Largest distance of a touch-down from the wall [m]; chosen: a tilted bin keeps its objects nearer to the wall."""

FORGETTING = 0.8
"""Share of what the bandit remembers of an attempt after the next one [-]; chosen, because the pile changes."""


class Told(NamedTuple):
    """What an operator without eyes knows of an attempt.

    Attributes:
        line: Index of the line.
        delivered: Number of objects that were delivered, as it believes.
        pushed: Whether the push ended at F_grasp.
        peak_force: Largest force along the push [N].
    """

    line: int
    delivered: int
    pushed: bool
    peak_force: float


Rule = Callable[[Sequence[PushGoal], Sequence[Told], np.random.Generator], int]
"""Function from the lines, earlier attempts and random numbers to the index of the next line."""


def fixed_lines(goals: Sequence[PushGoal]) -> tuple[PushGoal, ...]:
    """Return the lines of a bin: those of each goal from its middle outwards, the goals in turn.

    Args:
        goals: Push goals; the lines lie within their lateral ranges.
    """
    rows = [[_on_line(goal, offset) for offset in _offsets(*goal.lateral_range)] for goal in goals]
    return tuple(row[place] for place in range(max(map(len, rows), default=0)) for row in rows if place < len(row))


def touch_distance(line: PushGoal) -> float:
    """Return the distance of the touch-down from the line's anchor [m]: as far as hand and arm have room."""
    return min(line.longest, FARTHEST)


def _offsets(least: float, greatest: float) -> list[float]:
    """Return evenly spaced offsets, the middle one first."""
    count = 1 + int(np.ceil((greatest - least) / SPACING - 1e-9))
    middle = 0.5 * (least + greatest)
    step = (greatest - least) / (count - 1) if count > 1 else 0.0
    found = [least + step * place for place in range(count)]
    return sorted(found, key=lambda offset: (round(abs(offset - middle), 9), offset))


def _on_line(goal: PushGoal, offset: float) -> PushGoal:
    import math

    left: Array = np.array([-math.sin(goal.yaw), math.cos(goal.yaw)])
    return replace(goal, anchor=goal.anchor + offset * left, lateral_range=(0.0, 0.0))


def alternates(lines: Sequence[PushGoal], told: Sequence[Told], random: np.random.Generator) -> int:
    """Take the lines in turn."""
    return len(told) % len(lines)


def bandit(lines: Sequence[PushGoal], told: Sequence[Told], random: np.random.Generator) -> int:
    """Take the line with the best draw from its beta distribution (W. R. Thompson, Biometrika 25 (1933), p. 285).

    A delivery counts as a success. No delivery counts as a failure, and as two if the push met nothing that held it.
    Older attempts count less.
    """
    wins, losses = np.ones(len(lines)), np.ones(len(lines))
    for attempt in told:
        wins, losses = 1.0 + FORGETTING * (wins - 1.0), 1.0 + FORGETTING * (losses - 1.0)
        if attempt.delivered:
            wins[attempt.line] += 1.0
        else:
            losses[attempt.line] += 1.0 if attempt.pushed else 2.0
    return int(random.beta(wins, losses).argmax())


RULES: dict[str, Rule] = {"alternates": alternates, "bandit": bandit}
"""Rules by the value of `order.operator`; "sees" is no rule."""


def rule_of(name: str) -> Rule:
    """Return a shipped rule, or a user's `module:function`.

    Raises:
        ConfigurationError: The function cannot be loaded, or has other parameters.
    """
    return load_plugin(name, "order.operator", RULE_PARAMETERS, named=True).function if is_plugin(name) else RULES[name]
