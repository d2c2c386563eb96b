"""The timeline under a scene: lanes of signals on one clock over the bands of the primitives, without a script."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from pilegrasp_ctrl.analysis.reading import plain
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.viewer.lane import Axes, Curve, Lane, nice_ticks, scalar_signal
from pilegrasp_ctrl.viewer.summary import Event, Phase, Summary, events

SMALLEST_FORCE = 2.0
"""The lane of forces reaches up to this at least, so that the sensor's noise looks like noise [N]."""

SMALLEST_ERROR = 1.0
"""The same for the tracking error [mm] and the orientation error [°]."""


def lanes(recording: Recording, grasp_force: float | None) -> list[Lane]:
    """Return the lanes of an attempt from top to bottom; one whose signals were not recorded is missing."""
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
        # The bands need a place, so this lane is there in any case.
        Lane("force", "N", force, 108, threshold, least=SMALLEST_FORCE),
        Lane("tracking error", "mm", curves(("tracking_error", "tracking error", 1e3)), 44, least=SMALLEST_ERROR),
        Lane("joint torques, of their limits", "%", _joints(recording), 56, fixed=(0.0, 100.0)),
        Lane("closure", "%", curves(("closure", "closure", 100.0)), 36, fixed=(0.0, 100.0)),
        Lane(
            "orientation error",
            "°",
            curves(("orientation_error", "orientation error", 180.0 / np.pi)),
            44,
            least=SMALLEST_ERROR,
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


def styles(phases: Sequence[Phase]) -> list[str]:
    """Return a CSS class for each phase; equal names share a colour."""
    names = list(dict.fromkeys(phase.name for phase in phases))
    return [f"p{names.index(phase.name) % 6}" for phase in phases]


def _band(axes: Axes, phase: Phase, style: str) -> str:
    left, right = axes.across(phase.start), axes.across(phase.end)
    failed = " failed" if phase.failed else ""
    hint = f"{phase.name}: {phase.start:.2f} to {phase.end:.2f} s, {phase.trigger or 'no trigger named'}"
    cause = f"<small>→ {escape(plain(phase.trigger))}</small>" if phase.trigger else ""
    return (
        f'<div class="band {style}{failed}" style="left:{100 * left:.2f}%;width:{100 * (right - left):.2f}%"'
        f' title="{escape(hint)}"><span><b>{escape(phase.name)}</b>{cause}</span></div>'
    )


def _mark(axes: Axes, event: Event) -> str:
    return (
        f'<i class="mark {event.kind}" style="left:{100 * axes.across(event.time):.2f}%"'
        f' title="{escape(f"{event.time:.2f} s: {event.words}")}"></i>'
    )


def timeline(recording: Recording, summary: Summary, window: tuple[float, float]) -> str:
    """Return the figure: bands, marks of the events, lanes, ticks, and one cursor that the page's script moves.

    It shows the time between the two ends of `window` [s], which it carries in `data-start` and `data-end`.
    """
    start, end = window
    end = end if end > start else start + 1.0
    clock = Axes(start, end, 0.0, 1.0)
    bands = "".join(
        _band(clock, phase, style) for phase, style in zip(summary.phases, styles(summary.phases), strict=True)
    )
    marks = "".join(_mark(clock, event) for event in events(recording, summary.phases))
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
