"""One picture of an attempt: the moments that tell what happened, side by side, under the verdict."""

from __future__ import annotations

import os
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from pilegrasp_ctrl.analysis.reading import plain
from pilegrasp_ctrl.exceptions import ExportError
from pilegrasp_ctrl.files import write_whole
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.viewer.stills import Progress, Stills
from pilegrasp_ctrl.viewer.summary import Phase, Summary, summarize

TILES = 9
"""Moments between the primitives' ends are added up to this number."""

MOST_TILES = 24
"""A recording may name any number of primitives; of more than fit, the first are shown and the end."""

_SAME = 0.05
"""Moments nearer than this [s] are one: nothing that can be seen happens between them."""


@dataclass(frozen=True, slots=True)
class Moment:
    """A tile: `time` [s], up to two lines of words, and whether a primitive failed here."""

    time: float
    words: tuple[str, ...]
    failed: bool = False


def ink(success: bool | None) -> str:
    """Return the name of the page's colour for a verdict."""
    return {True: "good", False: "bad", None: "soft"}[success]


def title(summary: Summary) -> str:
    """Return the scenario and its seed."""
    return summary.scenario + (f", seed {summary.seed}" if summary.seed else "")


def _ending(phase: Phase) -> str:
    cause = plain(phase.trigger)
    return f"{phase.name} {'failed' if phase.failed else 'ends'}{f': {cause}' if cause else ''}"


def moments(recording: Recording) -> tuple[Moment, ...]:
    """Return the moments to show, in order: first and last frame, start and end of each primitive, and some between.

    A primitive that begins where another ends shares its moment. What lies outside the recorded frames is left out.
    """
    first, last = float(recording.frame_time[0]), float(recording.frame_time[-1])
    phases = summarize(recording.meta).phases
    marks = [(first, "", False), (last, "", False)]
    for phase in phases:
        marks.append((phase.start, f"{phase.name} begins", False))
        marks.append((phase.end, _ending(phase), phase.failed))
    # Frames are up to a period apart from a primitive's end, so an end just behind the last frame still counts.
    marks = sorted((mark for mark in marks if first - _SAME <= mark[0] <= last + _SAME), key=lambda mark: mark[0])
    found: list[Moment] = []
    for time, word, failed in marks:
        time = min(max(time, first), last)
        words = (word,) if word else ()
        if found and time - found[-1].time < _SAME:
            before = found.pop()
            found.append(Moment(before.time, before.words + words, before.failed or failed))
        else:
            found.append(Moment(time, words, failed))
    if len(found) > MOST_TILES:
        found = [*found[: MOST_TILES - 1], found[-1]]
    while 1 < len(found) < TILES:
        gap, index = max((b.time - a.time, k) for k, (a, b) in enumerate(pairwise(found)))
        if gap < 4 * _SAME:
            break
        time = 0.5 * (found[index].time + found[index + 1].time)
        name = next((phase.name for phase in phases if phase.start <= time < phase.end), "")
        found.insert(index + 1, Moment(time, (name,) if name else ()))
    return tuple(found)


def write_png(recording: Recording, path: str | os.PathLike[str], progress: Progress | None = None) -> None:
    """Write the contact sheet as PNG, all of it or nothing.

    Raises:
        ExportError: where no Chromium is found, it cannot draw, or the place cannot be written.
    """
    summary = summarize(recording.meta)
    shown = moments(recording)
    with Stills(recording) as stills:
        head = {"title": title(summary), "verdict": summary.verdict, "reason": summary.reason}
        stills.open_sheet(len(shown), head | {"ink": ink(summary.success)})
        for index, moment in enumerate(shown):
            stills.add_tile(index, moment.time, moment.words, moment.failed)
            if progress:
                progress(index + 1, len(shown))
        picture = stills.sheet()
    try:
        write_whole(Path(path), picture)
    except (OSError, ValueError) as error:
        raise ExportError(f"the picture cannot be written to {str(path)!r}: {error}") from error
