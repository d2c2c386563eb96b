"""Safe access to the entries of a recording, because any key of its meta and any signal may be missing or wrong."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..recording import Recording
from ..types import Array

MAX_TEXT_LENGTH = 300
"""Greatest length of a text from a recording [characters]; chosen."""


def number(value: Any) -> float | None:
    """Return a finite float, or None if `value` is something else."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    try:
        result = float(value)
    except OverflowError:
        return None
    return result if math.isfinite(result) else None


def text(value: Any, limit: int = MAX_TEXT_LENGTH) -> str:
    """Return `value` as plain text of at most `limit` characters; None becomes the empty text."""
    if value is None:
        return ""
    if isinstance(value, float):
        return f"{value:g}"
    words = str(value)
    return words if len(words) <= limit else words[: limit - 1] + "…"


def plain(trigger: str) -> str:
    """Return a trigger with spaces for underscores if it is an identifier, otherwise as it is."""
    return trigger.replace("_", " ") if trigger.isidentifier() else trigger


def lookup(table: Any, dotted: str) -> Any:
    """Return the entry of a nested table, or None if a level is missing."""
    for key in dotted.split("."):
        table = table.get(key) if isinstance(table, Mapping) else None
    return table


def strategy_number(recording: Recording, name: str, default: float) -> float:
    """Return a number of the recorded strategy, or `default` if the configuration does not hold it."""
    noted = number(lookup(recording.meta, f"config.strategy.{name}"))
    return default if noted is None else noted


def first_outcome(recording: Recording, name: str) -> Mapping[str, Any] | None:
    """Return the outcome of the first primitive called `name`, or None if there is none with a start and an end."""
    outcomes = recording.meta.get("outcomes")
    for row in outcomes if isinstance(outcomes, list) else []:
        if isinstance(row, Mapping) and row.get("name") == name:
            return row if None not in (number(row.get("start")), number(row.get("end"))) else None
    return None


def signal_at(recording: Recording, name: str, times: Array, width: int = 3) -> Array | None:
    """Return the first `width` columns of a signal, interpolated at `times` (F, width), or None if it is absent."""
    signal = recording.signals.get(name)
    if signal is None or signal.ndim != 2 or signal.shape[1] < width or not signal.size:
        return None
    columns = [np.interp(times, recording.signal_time, signal[:, column]) for column in range(width)]
    return np.stack(columns, axis=1)
