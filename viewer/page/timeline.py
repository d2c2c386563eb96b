"""The timeline under a scene: lanes of signals on one clock over the bands of the primitives, without a script."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from markupsafe import Markup

from pilegrasp_ctrl.analysis.carried import Carried
from pilegrasp_ctrl.analysis.reading import plain
from pilegrasp_ctrl.viewer.page.events import Event
from pilegrasp_ctrl.viewer.page.lane import Axes, Lane, nice_ticks
from pilegrasp_ctrl.viewer.page.summary import PrimitiveRow, Summary
from pilegrasp_ctrl.viewer.templates import render

ROW_HEIGHT = 15
"""Height of an object's row in the lane of what the hand carried [px]; chosen."""

MAX_ROWS = 6
"""Largest number of rows in that lane; chosen. Further objects share the last one."""


@dataclass(frozen=True, slots=True)
class Timeline:
    """What a timeline shows.

    Attributes:
        window: First and last time of the figure [s].
        lanes: Lanes from top to bottom.
        ranges: Common range of the lanes of each key.
        events: Events in order of time.
        carried: Times of objects in the hand; None if no objects were recorded.
        paint: Colour of each object in the scene, as CSS, by its name.
        rows: Least number of rows of the lane of what the hand carried; two timelines beside each other share it.
    """

    window: tuple[float, float]
    lanes: Sequence[Lane]
    ranges: Mapping[str, tuple[float, float]]
    events: Sequence[Event]
    carried: Sequence[Carried] | None
    paint: Mapping[str, str]
    rows: int = 1


def styles(rows: Sequence[PrimitiveRow]) -> list[str]:
    """Return a CSS class for each primitive; equal names share a colour."""
    number = {name: index for index, name in enumerate(dict.fromkeys(row.name for row in rows))}
    return [f"p{number[row.name] % 6}" for row in rows]


def _place(axes: Axes, start: float, end: float) -> str:
    left, right = axes.across(start), axes.across(end)
    return f"left:{100 * left:.2f}%;width:{100 * (right - left):.2f}%"


def _bands(axes: Axes, summary: Summary) -> list[dict[str, Any]]:
    return [
        {
            "name": plain(row.name),
            "style": style,
            "failed": row.failed,
            "place": _place(axes, row.start, row.end),
            "cause": plain(row.trigger),
            "hint": f"{plain(row.name)}: {row.start:.2f} to {row.end:.2f} s, {plain(row.trigger) or 'no trigger'}",
        }
        for row, style in zip(summary.primitives, styles(summary.primitives), strict=True)
    ]


def _attempts(axes: Axes, summary: Summary) -> list[dict[str, Any]]:
    return [
        {
            "number": row.number,
            "failed": not row.delivered,
            "place": _place(axes, row.start, row.end),
            "words": row.words,
            "hint": f"attempt {row.number}, {row.start:.1f} to {row.end:.1f} s: {row.held} held, {row.words}",
        }
        for row in summary.attempts
    ]


def rows_of(carried: Sequence[Carried]) -> list[int]:
    """Return the row of each bar: the first that is free, so that the attempts of an order share rows."""
    free: list[float] = []
    rows = []
    for one in carried:
        row = next((index for index, end in enumerate(free) if end <= one.start), len(free))
        if row < MAX_ROWS - 1:
            free[row : row + 1] = [one.end]
        rows.append(row)
    return rows


def _bars(axes: Axes, carried: Sequence[Carried], paint: Mapping[str, str]) -> list[dict[str, Any]]:
    return [
        {
            "name": plain(one.object),
            "short": re.sub(r"^.*\D(?=\d+$)", "", one.object),
            "object": one.object,
            "paint": paint.get(one.object, "none"),
            "ending": one.ending,
            "row": row,
            "place": _place(axes, one.start, one.end),
            "hint": f"{plain(one.object)} in the hand from {one.start:.2f} to {one.end:.2f} s, then {one.ending}",
        }
        for one, row in zip(carried, rows_of(carried), strict=True)
    ]


def timeline(shown: Timeline, summary: Summary) -> Markup:
    """Return the figure: attempts, bands, marks of the events, lanes, ticks, and a cursor that the script moves."""
    start, end = shown.window
    end = end if end > start else start + 1.0
    clock = Axes(start, end, 0.0, 1.0)
    ticks = nice_ticks(start, end, 10)
    decimals = max(0, -int(np.floor(np.log10(ticks[1] - ticks[0])))) if len(ticks) > 1 else 1
    bars = None if shown.carried is None else _bars(clock, shown.carried, shown.paint)
    return render(
        "page/timeline.html",
        start=f"{start:.4f}",
        end=f"{end:.4f}",
        attempts=_attempts(clock, summary),
        bands=_bands(clock, summary),
        marks=[
            {
                "kind": event.kind,
                "place": f"left:{100 * clock.across(event.time):.2f}%",
                "time": f"{event.time:.4f}",
                "hint": f"{event.time:.2f} s: {event.words}",
            }
            for event in shown.events
        ],
        bars=bars,
        bar_rows=max(shown.rows, 1 + max((bar["row"] for bar in bars or ()), default=0)),
        row_height=ROW_HEIGHT,
        lanes=[lane.drawing(lane.axes(start, end, shown.ranges.get(lane.key))) for lane in shown.lanes],
        ticks=[(f"{100 * clock.across(t):.2f}", f"{t:.{decimals}f}", k % 2) for k, t in enumerate(ticks)],
    )
