"""The timeline under a scene: lanes of signals on one clock over the bands of the primitives, without a script."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from pilegrasp_ctrl.analysis.reading import plain
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.viewer.lane import Axes, Curve, Lane, nice_ticks, scalar_signal
from pilegrasp_ctrl.viewer.summary import Event, PrimitiveRow, Summary, events

MIN_FORCE_SPAN = 2.0
"""Least upper end of the lane of forces [N], so that the sensor's noise looks small; chosen."""

MIN_ERROR_SPAN = 1.0
"""Least upper end of the lanes of tracking error [mm] and orientation error [°]; chosen."""


def lanes(recording: Recording, grasp_force: float | None) -> list[Lane]:
    """Return the lanes of an attempt from top to bottom, without those whose signals were not recorded."""
    time = recording.signal_time

    def curves(*named: tuple[str, str, float]) -> list[Curve]:
        found = [(label, scalar_signal(recording, name), scale) for name, label, scale in named]
        return [
            Curve(label, time, scale * values, f"c{index}")
            for index, (label, values, scale) in enumerate(found)
            if values is not None
        ]

    force = curves(("push_force", "push force", 1.0), ("normal_force", "normal force", 1.0))
    threshold = (f"F_grasp {grasp_force:g} N", grasp_force) if grasp_force is not None else None
    everything = [
        # The lane of forces is always drawn, because the bands need a lane.
        Lane("force", "N", force, 108, threshold, min_top=MIN_FORCE_SPAN),
        Lane("tracking error", "mm", curves(("tracking_error", "tracking error", 1e3)), 44, min_top=MIN_ERROR_SPAN),
        Lane("joint torques, of their limits", "%", _joints(recording), 56, fixed=(0.0, 100.0)),
        Lane("closure", "%", curves(("closure", "closure", 100.0)), 36, fixed=(0.0, 100.0)),
        Lane(
            "orientation error",
            "°",
            curves(("orientation_error", "orientation error", 180.0 / np.pi)),
            44,
            min_top=MIN_ERROR_SPAN,
        ),
    ]
    return [lane for index, lane in enumerate(everything) if lane.curves or index == 0]


def _joints(recording: Recording) -> list[Curve]:
    ratio = recording.signals.get("torque_ratio")
    if ratio is None or ratio.ndim != 2 or not ratio.size:
        return []
    columns = 100.0 * np.abs(ratio.astype(np.float64)).T[:12]
    return [
        Curve(f"joint {index + 1}", recording.signal_time, column, f"j{index % 7}")
        for index, column in enumerate(columns)
    ]


def styles(rows: Sequence[PrimitiveRow]) -> list[str]:
    """Return a CSS class for each primitive; equal names share a colour."""
    names = list(dict.fromkeys(row.name for row in rows))
    return [f"p{names.index(row.name) % 6}" for row in rows]


def _band(axes: Axes, row: PrimitiveRow, style: str) -> str:
    left, right = axes.across(row.start), axes.across(row.end)
    failed = " failed" if row.failed else ""
    hint = f"{row.name}: {row.start:.2f} to {row.end:.2f} s, {row.trigger or 'no trigger named'}"
    cause = f"<small>→ {escape(plain(row.trigger))}</small>" if row.trigger else ""
    return (
        f'<div class="band {style}{failed}" style="left:{100 * left:.2f}%;width:{100 * (right - left):.2f}%"'
        f' title="{escape(hint)}"><span><b>{escape(row.name)}</b>{cause}</span></div>'
    )


def _mark(axes: Axes, event: Event) -> str:
    return (
        f'<i class="mark {event.kind}" style="left:{100 * axes.across(event.time):.2f}%"'
        f' title="{escape(f"{event.time:.2f} s: {event.words}")}"></i>'
    )


def timeline(recording: Recording, summary: Summary, window: tuple[float, float]) -> str:
    """Return the figure: bands, marks of the events, lanes, ticks, and one cursor that the page's script moves.

    The figure shows the time between the two ends of `window` [s] and keeps them in `data-start` and `data-end`.
    """
    start, end = window
    end = end if end > start else start + 1.0
    clock = Axes(start, end, 0.0, 1.0)
    bands = "".join(
        _band(clock, row, style) for row, style in zip(summary.primitives, styles(summary.primitives), strict=True)
    )
    marks = "".join(_mark(clock, event) for event in events(recording, summary.primitives))
    rows = "".join(lane.html(start, end) for lane in lanes(recording, summary.grasp_force))
    ticks = nice_ticks(start, end, 10)
    decimals = max(0, -int(np.floor(np.log10(ticks[1] - ticks[0])))) if len(ticks) > 1 else 1
    labels = "".join(
        f'<span class="tx{" odd" if k % 2 else ""}" style="left:{100 * clock.across(t):.2f}%">{t:.{decimals}f}</span>'
        for k, t in enumerate(ticks)
    )
    return (
        f'<figure class="timeline"><div class="plot" data-start="{start:.4f}" data-end="{end:.4f}">{bands}'
        f'<div class="marks">{marks}</div>{rows}<div class="ticks">{labels}<span class="unit">[s]</span></div>'
        '<div class="cursor"><i></i></div></div></figure>'
    )
