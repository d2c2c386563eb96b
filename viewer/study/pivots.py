"""What a study's page counts: success over any two of its keys, and failures by their reason."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import permutations
from typing import Any

from pilegrasp_ctrl.statistics import wilson
from pilegrasp_ctrl.viewer.study.picks import kind_of_reason
from pilegrasp_ctrl.viewer.study.rows import IndexRow

MAX_VALUES = 40
"""Largest number of values of a key that can be chosen for the plot; chosen, more are not legible."""
MAX_KEYS = 8
"""Largest number of keys that can be chosen for the plot, the first ones; chosen, it bounds the size of the page."""


def labels_of(rows: Sequence[IndexRow]) -> dict[str, list[str]]:
    """Return the values of each key of the conditions: numbers by size, others in the order of their appearance."""
    found: dict[str, dict[str, None]] = {label: {} for row in rows for label, _ in row.condition}
    for row in rows:
        for label, value in row.values.items():
            found[label][value] = None
    return {label: _in_order(list(values)) for label, values in found.items()}


def _in_order(values: list[str]) -> list[str]:
    try:
        return sorted(values, key=float)
    except ValueError:
        return values


def pivots(rows: Sequence[IndexRow]) -> list[dict[str, Any]]:
    """Return success over each key, alone and apart by each other key, as values of JSON.

    Attempts that differ in other keys are counted together. A cell is None without attempts, otherwise attempts,
    successes, and Wilson's 95 % interval of the rate.
    """
    values = {label: found for label, found in labels_of(rows).items() if 1 < len(found) <= MAX_VALUES}
    keys = list(values)[:MAX_KEYS]
    return [_pivot(rows, values, x, by) for x, by in ((x, None) for x in keys)] + [
        _pivot(rows, values, x, by) for x, by in permutations(keys, 2)
    ]


def _pivot(rows: Sequence[IndexRow], values: dict[str, list[str]], x: str, by: str | None) -> dict[str, Any]:
    n: Counter[tuple[str, str]] = Counter()
    successes: Counter[tuple[str, str]] = Counter()
    for row in rows:
        own = row.values
        if x in own and (by is None or by in own):
            cell = (own[x], "" if by is None else own[by])
            n[cell] += 1
            successes[cell] += row.success is True
    series = [""] if by is None else values[by]
    return {
        "x": x,
        "by": by or "",
        "values": values[x],
        "series": series,
        "cells": [[_cell(n[value, one], successes[value, one]) for value in values[x]] for one in series],
    }


def _cell(n: int, successes: int) -> list[float] | None:
    if n == 0:
        return None
    low, high = wilson(successes, n)
    return [n, successes, round(low, 4), round(high, 4)]


def reasons(rows: Sequence[IndexRow]) -> list[tuple[str, int]]:
    """Return the kinds of reasons of failures and errors with their numbers of attempts, the most frequent first."""
    return Counter(kind_of_reason(row.words) for row in rows if row.success is not True).most_common()
