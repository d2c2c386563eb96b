"""How hard the end-effector presses on the table while it pushes, from the wrist sensor's record."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..recording import Recording

UNLOADED = 0.3
"""The force at the start of the approach, when nothing touches the hand, is averaged over this time [s]."""


def table_force(recording: Recording) -> dict[str, float] | None:
    """Return `mean` and `peak` of the vertical force on the hand during the push [N], or None without a push.

    Relative to the air before touch-down, so that what the hand already bears when the push begins counts. Objects bear
    on a sloping hand too, but for most of a push the table does.
    """
    window = {name: _window(recording, name) for name in ("approach", "push")}
    if window["approach"] is None or window["push"] is None:
        return None
    time, vertical = recording.signal_time, recording.signals["wrench"][:, 2].astype(float)
    air = time <= window["approach"][0] + UNLOADED
    pushing = (time >= window["push"][0]) & (time <= window["push"][1])
    if not air.any() or not pushing.any():
        return None
    force = vertical[pushing] - vertical[air].mean()
    return {"mean": float(np.mean(force)), "peak": float(force.max())}


def _window(recording: Recording, name: str) -> tuple[float, float] | None:
    outcomes: Any = recording.meta.get("outcomes", ())
    for outcome in outcomes:
        if isinstance(outcome, Mapping) and outcome.get("name") == name:
            return float(outcome["start"]), float(outcome["end"])
    return None
