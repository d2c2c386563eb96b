"""The time between two periods, which should be the one that a controller was made for."""

from __future__ import annotations

import warnings

from ..exceptions import PeriodWarning

MIN_ELAPSED, MAX_ELAPSED = 0.5, 1.5
"""Elapsed time over the stated period, between which an observation counts as one period after the last; chosen."""


def notice_period(last: float | None, time: float, rate: float) -> None:
    """Warn if an observation at `time` [s] came neither with the last one nor a period of `rate` [Hz] after it."""
    if last is None:
        return
    periods = (time - last) * rate
    if periods > MAX_ELAPSED or 0.0 < periods < MIN_ELAPSED:
        warnings.warn(
            f"an observation came {1e3 * (time - last):.3g} ms after the last one, but the controller was made for "
            f"{rate:g} Hz, and its limits look ahead by that period; make it with the rate at which you call step, "
            "and call reset() before a new motion",
            PeriodWarning,
            stacklevel=4,
        )
