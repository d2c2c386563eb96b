"""What the judging code reads of an attempt: truths and numbers by name, as columns over a condition's attempts."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from pilegrasp_ctrl.study.attempt import AttemptRow
from pilegrasp_ctrl.types import Array

EVENTS = (("approach", ("surface contact",)), ("push", ("grasp force",)), ("grasp", ("closed", "tilted back")))
"""The three primitives of the paper (IV) and the events that end them; the shovel closes by tilting back. The closing
is a timer, so C16 asks for the first two."""
REST = 0.1
"""Time for which the separated object must have been at rest relative to the hand at the trigger [s]; claims, C13."""


def measure(row: AttemptRow, *path: str) -> Any:
    """Return the measure at `path` of an attempt, or None if it has none."""
    value: Any = None if row.result is None else row.result.get("measures")
    for key in path:
        value = value.get(key) if isinstance(value, Mapping) else None
    return value


def shows_events(result: Mapping[str, Any]) -> bool:
    """Return whether touch-down and F_grasp ended their primitives, and the hand then closed, each after the other."""
    outcomes = result["outcomes"][: len(EVENTS)]
    if len(outcomes) < len(EVENTS):
        return False
    named_right = all(
        outcome["name"] == name and outcome["trigger"] in triggers
        for outcome, (name, triggers) in zip(outcomes, EVENTS, strict=True)
    )
    times = [time for outcome in outcomes for time in (outcome["start"], outcome["end"])]
    return named_right and times == sorted(times)


def separates(row: AttemptRow) -> bool:
    """Return whether exactly one object was at the hand at the trigger and had been at rest there for `REST`."""
    inside, since = measure(row, "motion", "in_hand"), measure(row, "motion", "separated", "stabilised")
    if not row.triggered or since is None or len(inside or ()) != 1:
        return False
    end = next(outcome["end"] for outcome in (row.result or {})["outcomes"] if outcome["trigger"] == "grasp force")
    return bool(end - since >= REST)


def _order_attempts(row: AttemptRow) -> float | None:
    attempts = (row.result or {}).get("attempts")
    return None if attempts is None else float(len(attempts))


def _chance(row: AttemptRow) -> float | None:
    """Return the chance that an object drawn from those at the hand is held; None without a success or an object."""
    inside, held = measure(row, "motion", "in_hand"), measure(row, "motion", "held")
    return len(set(inside) & set(held)) / len(inside) if inside and held else None


FLAGS: dict[str, Callable[[AttemptRow], bool]] = {
    "success": lambda row: row.success,
    "several": lambda row: row.success and row.grasped > 1,
    "triggered": lambda row: row.triggered,
    "error": lambda row: row.error is not None,
    "astray": lambda row: row.success and row.result is not None and not shows_events(row.result),
    "separated": separates,
    "within reach": lambda row: not row.triggered and bool(measure(row, "motion", "in_hand")),
    "foreseen": lambda row: bool(measure(row, "motion", "agreed")),
    "asked": lambda row: measure(row, "motion", "agreed") is not None,
}
"""Truths of an attempt by name.

"astray": a success without the paper's events in order. "within reach": an object was at the hand when a push ended
that never reached F_grasp. "asked": an object is held, so that there was something to name. "foreseen": the object
that the rule named is held."""

NUMBERS: dict[str, Callable[[AttemptRow], float | None]] = {
    "grasped": lambda row: float(row.grasped) if row.success else 0.0,
    "order attempts": _order_attempts,
    "approach speed": lambda row: measure(row, "motion", "approach_speed"),
    "spread speed": lambda row: measure(row, "motion", "spread_speed"),
    "table force": lambda row: measure(row, "table_force", "peak"),
    "chance": _chance,
}
"""Numbers of an attempt by name, in SI units; None where the attempt has none."""


class Block:
    """The attempts of one condition, sorted by seed, and their columns.

    Attributes:
        rows: Attempts.
        broken: Whether one of them raised.
    """

    def __init__(self, rows: tuple[AttemptRow, ...]) -> None:
        """Sort the rows by seed."""
        self.rows = tuple(sorted(rows, key=lambda row: row.seed))
        self.broken = any(row.error is not None for row in self.rows)
        self._columns: dict[str, Array] = {}

    def column(self, name: str) -> Array:
        """Return a truth (0 or 1) or a number of every attempt (n,); not a number where an attempt has none."""
        if name not in self._columns:
            read: Callable[[AttemptRow], Any] = FLAGS[name] if name in FLAGS else NUMBERS[name]
            found = [read(row) for row in self.rows]
            self._columns[name] = np.array([np.nan if value is None else float(value) for value in found])
        return self._columns[name]
