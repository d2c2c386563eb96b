"""Entries of a recording's meta, read without trusting them: a file may lack or garble any key."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any


def number(value: Any) -> float | None:
    """Return a finite float, or None where `value` is something else."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    try:
        result = float(value)
    except OverflowError:
        return None
    return result if math.isfinite(result) else None


def text(value: Any, limit: int = 300) -> str:
    """Return a short plain text; None is empty."""
    if value is None:
        return ""
    if isinstance(value, float):
        return f"{value:g}"
    words = str(value)
    return words if len(words) <= limit else words[: limit - 1] + "…"


def plain(trigger: str) -> str:
    """Return a trigger as words, where it is an identifier."""
    return trigger.replace("_", " ") if trigger.isidentifier() else trigger


def lookup(table: Any, dotted: str) -> Any:
    """Return the entry of a nested table, or None where a level is missing."""
    for key in dotted.split("."):
        table = table.get(key) if isinstance(table, Mapping) else None
    return table
