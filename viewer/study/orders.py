"""Orders of a study: attempts an order, picks an hour, and what went wrong in the attempts."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from pilegrasp_ctrl.statistics import ratio_interval, wilson
from pilegrasp_ctrl.viewer.study.picks import kind_of_reason
from pilegrasp_ctrl.viewer.study.rows import IndexRow

Estimate = tuple[float, float, float]
"""A value and its 95 % interval."""


@dataclass(frozen=True, slots=True)
class Orders:
    """The orders of one condition.

    Attributes:
        condition: Label and value of each key of the condition.
        n: Number of orders.
        completed: Number of complete ones.
        limits: 95 % interval of their share.
        attempts: Mean number of attempts of a complete order; None without one.
        picks_an_hour: Delivered objects in an hour of simulated time, that of all deliveries and returns included
            [1/h]; None if no time is known.
        tries: Number of attempts of all orders.
        wrong: What went wrong in attempts, with the number of attempts, the most frequent first.
    """

    condition: tuple[tuple[str, str], ...]
    n: int
    completed: int
    limits: tuple[float, float]
    attempts: Estimate | None
    picks_an_hour: Estimate | None
    tries: int
    wrong: tuple[tuple[str, int], ...]

    def as_dict(self) -> dict[str, Any]:
        """Return plain JSON values."""
        return {
            "condition": dict(self.condition),
            "orders": self.n,
            "completed": self.completed,
            "completed_limits": list(self.limits),
            "attempts_an_order": _as_dict(self.attempts),
            "picks_an_hour": _as_dict(self.picks_an_hour),
            "attempts": self.tries,
            "wrong": [{"reason": words, "attempts": count} for words, count in self.wrong],
        }


def _as_dict(found: Estimate | None) -> dict[str, float | None] | None:
    if found is None:
        return None
    return {"value": found[0], "low": found[1], "high": found[2] if math.isfinite(found[2]) else None}


def orders_of(rows: Sequence[IndexRow]) -> list[Orders]:
    """Return the orders of each condition that has any, in the order of the rows."""
    groups: dict[str, list[IndexRow]] = {}
    for row in rows:
        if row.picks:
            groups.setdefault(row.config_hash, []).append(row)
    return [_orders(group) for group in groups.values()]


def _orders(rows: Sequence[IndexRow]) -> Orders:
    complete = [row for row in rows if row.success]
    timed = [(row.picks, row.duration) for row in rows if row.duration is not None and row.duration > 0.0]
    wrong = Counter(kind_of_reason(pick.wrong) for row in rows for pick in row.picks if pick.wrong)
    return Orders(
        rows[0].condition,
        len(rows),
        len(complete),
        wilson(len(complete), len(rows)),
        ratio_interval([len(row.picks) for row in complete], [1.0] * len(complete)),
        ratio_interval(
            [3600.0 * sum(pick.delivered for pick in picks) for picks, _ in timed], [time for _, time in timed]
        ),
        sum(len(row.picks) for row in rows),
        tuple(wrong.most_common()),
    )
