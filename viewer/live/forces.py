"""The forces of a running attempt: their values, and their curves over the last seconds."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from typing import Any

WINDOW = 10.0
"""Time that the curves show [s]; chosen."""

PERIOD = 1.0 / 30.0
"""Time between two points of a curve [s]; chosen. The force of largest size in between is kept, so that no peak is
lost."""

FORCES = ("push_force", "normal_force")
"""Signals that are shown [N], in the order of the page's lane of forces."""


class Forces:
    """Forces of the last `WINDOW` seconds.

    A page that opens late or skips frames needs no other message, because each one holds the whole curves.
    """

    def __init__(self) -> None:
        self._points: deque[list[float]] = deque()
        self._values: dict[str, float] = {}
        self._next = 0.0

    def add(self, sample: Mapping[str, Any]) -> None:
        """Add a sample of the signals: `time` [s] and the `FORCES` [N]."""
        time = float(sample["time"])
        self._values = {name: float(sample[name]) for name in FORCES}
        if not self._points or time >= self._next - 1e-9:
            self._next = time + PERIOD
            self._points.append([time, *self._values.values()])
        else:
            last = self._points[-1]
            last[1:] = [max(pair, key=abs) for pair in zip(last[1:], self._values.values(), strict=True)]
        while time - self._points[0][0] > WINDOW:
            self._points.popleft()

    def message(self) -> dict[str, Any]:
        """Return JSON values: the last value of each force, and columns of times and forces; empty without samples."""
        if not self._points:
            return {}
        columns = zip(*self._points, strict=True)
        return {
            "values": [round(value, 2) for value in self._values.values()],
            "curves": [[round(value, 3) for value in column] for column in columns],
        }
