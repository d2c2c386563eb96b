"""A contact sheet: one picture of an attempt, with its key moments side by side."""

from __future__ import annotations

import os
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

from pilegrasp_ctrl.analysis.carried import carried_in, count_carried, shows_hand
from pilegrasp_ctrl.analysis.reading import plain
from pilegrasp_ctrl.exceptions import ExportError
from pilegrasp_ctrl.files import write_whole
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.viewer.page.summary import PrimitiveRow, Summary, summarize, tally
from pilegrasp_ctrl.viewer.pictures.stills import Moment, Progress, Stills

USUAL_TILES = 9
"""Number of tiles up to which moments between the primitives' ends are added; chosen: three rows of three."""

MAX_TILES = 24
"""Largest number of tiles; chosen. A recording with more moments shows the first of them and its end."""

MAX_LINES = 2
"""Largest number of lines of words under a tile."""

GRASPS = ("grasp", "lift")
"""Names of the primitives in which a tile shows the hand from near."""

SAME_MOMENT = 0.05
"""Difference in time below which two moments share a tile [s]; chosen, because nothing visible happens between them."""


def ink(success: bool | None) -> str:
    """Return the name of the page's colour for a verdict."""
    return {True: "good", False: "bad", None: "soft"}[success]


def title(summary: Summary) -> str:
    """Return the scenario and its seed."""
    return summary.scenario + (f", seed {summary.seed}" if summary.seed else "")


def _ending(row: PrimitiveRow) -> str:
    cause = plain(row.trigger)
    return f"{row.name} {'failed' if row.failed else 'ends'}{f': {cause}' if cause else ''}"


def moments(recording: Recording) -> tuple[Moment, ...]:
    """Return the moments to show, in order: first and last frame, ends of primitives, losses, and some between.

    A primitive that begins when another ends shares its moment. Moments outside the recorded frames are left out.
    """
    first, last = float(recording.frame_time[0]), float(recording.frame_time[-1])
    rows = summarize(recording.meta).primitives
    marks = [(first, "", False), (last, "", False)]
    for row in rows:
        marks.append((row.start, f"{row.name} begins", False))
        marks.append((row.end, _ending(row), row.failed))
    marks += [(one.end, f"lost {plain(one.object)}", True) for one in carried_in(recording) if one.ending == "lost"]
    # Frames are up to a period apart from a primitive's end, so an end just behind the last frame still counts.
    shown = (mark for mark in marks if first - SAME_MOMENT <= mark[0] <= last + SAME_MOMENT)
    marks = sorted(shown, key=lambda mark: mark[0])
    found: list[Moment] = []
    for time, word, failed in marks:
        time = min(max(time, first), last)
        words = (word,) if word else ()
        if found and time - found[-1].time < SAME_MOMENT:
            before = found.pop()
            both = (before.words + words)[:MAX_LINES]
            found.append(Moment(before.time, both, before.failed or failed))
        else:
            found.append(Moment(time, words, failed))
    if len(found) > MAX_TILES:
        found = [*found[: MAX_TILES - 1], found[-1]]
    while 1 < len(found) < USUAL_TILES:
        gap, index = max((b.time - a.time, k) for k, (a, b) in enumerate(pairwise(found)))
        if gap < 4 * SAME_MOMENT:
            break
        time = 0.5 * (found[index].time + found[index + 1].time)
        name = next((row.name for row in rows if row.start <= time < row.end), "")
        found.insert(index + 1, Moment(time, (name,) if name else ()))
    grasps = [(row.start, row.end) for row in rows if row.name in GRASPS]
    return tuple(
        replace(moment, near=any(a - SAME_MOMENT <= moment.time <= b + SAME_MOMENT for a, b in grasps))
        for moment in found
    )


def write_png(recording: Recording, path: str | os.PathLike[str], progress: Progress | None = None) -> None:
    """Write the contact sheet as PNG, all of it or nothing.

    Raises:
        ExportError: No Chromium is found, it cannot draw, or the place cannot be written.
    """
    summary = summarize(recording.meta)
    shown = moments(recording)
    with Stills(recording) as stills:
        counted = tally(count_carried(carried_in(recording)), summary.success) if shows_hand(recording) else ""
        reason = " · ".join(part for part in (summary.reason, counted) if part)
        head = {"title": title(summary), "verdict": summary.verdict, "reason": reason}
        stills.open_sheet(len(shown), head | {"ink": ink(summary.success)})
        for index, moment in enumerate(shown):
            stills.add_tile(index, moment)
            if progress:
                progress(index + 1, len(shown))
        picture = stills.sheet()
    try:
        write_whole(Path(path), picture)
    except (OSError, ValueError) as error:
        raise ExportError(f"the picture cannot be written to {str(path)!r}: {error}") from error
