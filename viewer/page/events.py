"""The events of a recording: what ended, failed, was lost, or reached its range, each with its moment."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pilegrasp_ctrl.analysis.carried import Carried, emptied
from pilegrasp_ctrl.analysis.reading import lookup, number, plain, text
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.viewer.page.summary import Summary

OUTSIDE = 0.1
"""Time by which an event may lie outside the recorded frames [s]; chosen: three frames."""


@dataclass(frozen=True, slots=True)
class Event:
    """A mark on the timeline: `kind` is "end", "failure", "loss", "separation" or "saturation"."""

    time: float
    kind: str
    words: str


def separated(meta: Mapping[str, Any]) -> tuple[str, float] | None:
    """Return the name of the object that separated from the pile and the time since then [s], if it is known."""
    name, time = (lookup(meta, f"motion.separated.{key}") for key in ("object", "time"))
    moment = number(time)
    return (name, moment) if isinstance(name, str) and moment is not None else None


def events(
    recording: Recording,
    summary: Summary,
    carried: Sequence[Carried] = (),
    separations: Sequence[tuple[str, float] | None] = (),
) -> list[Event]:
    """Return the events of a recording in order of time.

    Args:
        recording: Recording.
        summary: Its summary.
        carried: Times of objects in the hand.
        separations: Separated object and its moment of each attempt, as `separated` returns them.
    """
    found = []
    for row in summary.primitives:
        cause = plain(row.trigger) or ("failed" if row.failed else "ended")
        found.append(Event(row.end, "failure" if row.failed else "end", f"{plain(row.name)}: {cause}"))
    for one in carried:
        if one.ending == "lost":
            found.append(Event(one.end, "loss", f"lost {plain(one.object)}"))
    for apart in separations:
        if apart:
            found.append(Event(apart[1], "separation", f"{plain(text(apart[0], 40))} separates from the pile"))
    found += _failures(recording, summary, carried)
    saturated = recording.signals.get("sensor_saturated")
    if saturated is not None and saturated.ndim == 1 and (saturated > 0.5).any():
        moment = float(recording.signal_time[int(np.argmax(saturated > 0.5))])
        found.append(Event(moment, "saturation", "the wrist sensor is at its range"))
    first, last = float(recording.frame_time[0]), float(recording.frame_time[-1])
    shown = (event for event in found if first - OUTSIDE <= event.time <= last + OUTSIDE)
    return sorted(shown, key=lambda event: event.time)


def _failures(recording: Recording, summary: Summary, carried: Sequence[Carried]) -> list[Event]:
    """Return a moment for each failure that no primitive names: an empty hand, or an attempt that delivers nothing."""
    failed_at = sorted(row.end for row in summary.primitives if row.failed)
    whole = (float(recording.frame_time[0]), float(recording.frame_time[-1]))
    if summary.attempts:
        spans = [
            (row.start, row.end, row.held, f"attempt {row.number}: {row.words}")
            for row in summary.attempts
            if not row.delivered
        ]
    elif summary.success is False:
        spans = [(*whole, 0, summary.cause or "failed")]
    else:
        spans = []
    unnamed = []
    for span in spans:
        after = bisect_left(failed_at, span[0])
        if after == len(failed_at) or failed_at[after] > span[1] + OUTSIDE:
            unnamed.append(span)
    empty = iter(emptied(recording, carried, [(start, end) for start, end, held, _ in unnamed if not held]))
    found = []
    for start, end, held, words in unnamed:
        moment = None if held else next(empty)
        last = max(
            (row.end for row in summary.primitives if start <= row.start and row.end <= end + OUTSIDE), default=end
        )
        found.append(Event(last if moment is None else moment, "failure", words))
    return found
