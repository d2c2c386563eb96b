"""The attempts of a recording, one by one: the motion of each push, for the page shows that of the present attempt."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

import numpy as np

from pilegrasp_ctrl.analysis.reading import lookup, number
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.recording_parts import Contacts
from pilegrasp_ctrl.viewer.page.events import separated
from pilegrasp_ctrl.viewer.page.motion import forward, push_frame, with_motion
from pilegrasp_ctrl.viewer.page.summary import AttemptRow, Summary

MAX_SETTINGS = 100
"""Largest number of entries of a strategy that are read; chosen far above the number of its keys."""


@dataclass(frozen=True, slots=True)
class AttemptMotion:
    """The motion of one attempt.

    Attributes:
        start: Start of the attempt [s].
        end: End of the attempt [s].
        forward: Horizontal direction (2,) in which the pushing hand points.
        push: Leading edge and funnel of the push, as `push_frame` returns them.
        separated: Name of the separated object and the time since then [s].
    """

    start: float
    end: float
    forward: list[float]
    push: dict[str, Any] | None
    separated: tuple[str, float] | None


def attempt_motions(recording: Recording, summary: Summary) -> list[AttemptMotion]:
    """Return the motion of each attempt of an order, or of the one attempt; together they cover the recording."""
    first, last = float(recording.frame_time[0]), float(recording.frame_time[-1])
    if len(summary.attempts) < 2:
        return [_motion(with_motion(recording), first, last)]
    starts = [first, *(row.start for row in summary.attempts[1:])]
    ends = [*starts[1:], last]
    recording = replace(recording, meta=_needed(recording.meta))
    return [
        _motion(with_motion(_part(recording, row, start, end)), start, end)
        for row, start, end in zip(summary.attempts, starts, ends, strict=True)
        if ((recording.frame_time >= start) & (recording.frame_time <= end)).any()
    ]


def _motion(recording: Recording, start: float, end: float) -> AttemptMotion:
    return AttemptMotion(start, end, forward(recording), push_frame(recording), separated(recording.meta))


def _needed(meta: Mapping[str, Any]) -> dict[str, Any]:
    """Return what the measures of a motion read: the outcomes, and the numbers of the strategy."""
    outcomes, strategy = meta.get("outcomes"), lookup(meta, "config.strategy")
    entries = islice(strategy.items() if isinstance(strategy, Mapping) else (), MAX_SETTINGS)
    numbers = {name: value for name, value in entries if number(value) is not None}
    return {"outcomes": outcomes if isinstance(outcomes, list) else [], "config": {"strategy": numbers}}


def _part(recording: Recording, row: AttemptRow, start: float, end: float) -> Recording:
    """Return the frames, outcomes and signals of one attempt, and the samples just before and after it."""
    frames = np.flatnonzero((recording.frame_time >= start) & (recording.frame_time <= end))
    chosen = slice(int(frames[0]), int(frames[-1]) + 1)
    outcomes = [
        outcome
        for outcome in recording.meta["outcomes"]
        if (begun := number(lookup(outcome, "start"))) is not None and start <= begun < end
    ]
    before, after = np.searchsorted(recording.signal_time, (start, end)).tolist()
    samples = slice(max(0, before - 1), after + 1)
    contacts = recording.contacts
    if contacts is not None:
        bounds = contacts.start[chosen.start : chosen.stop + 1]
        rows = slice(int(bounds[0]), int(bounds[-1]))
        contacts = Contacts(bounds - bounds[0], contacts.bodies[rows], contacts.position[rows], contacts.force[rows])
    return replace(
        recording,
        meta={**recording.meta, "grasped": row.held, "outcomes": outcomes},
        signal_time=recording.signal_time[samples],
        signals={name: signal[samples] for name, signal in recording.signals.items()},
        frame_time=recording.frame_time[chosen],
        body_position=recording.body_position[chosen],
        body_quaternion=recording.body_quaternion[chosen],
        contacts=contacts,
    )
