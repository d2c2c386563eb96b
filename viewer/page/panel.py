"""One attempt on a page: head, scene, timeline and table as HTML, and the values that the page's script needs."""

from __future__ import annotations

import json
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import count
from typing import Any

import numpy as np
from markupsafe import Markup

from pilegrasp_ctrl.analysis.carried import Carried, carried_in, count_carried, shows_hand
from pilegrasp_ctrl.analysis.reading import plain, signal_at, text
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.viewer.page.attempts import AttemptMotion, attempt_motions
from pilegrasp_ctrl.viewer.page.command import repeat_command
from pilegrasp_ctrl.viewer.page.events import Event, events
from pilegrasp_ctrl.viewer.page.lane import Curve, Lane, scalar_signal
from pilegrasp_ctrl.viewer.page.lanes import lanes
from pilegrasp_ctrl.viewer.page.signal_block import signal_block
from pilegrasp_ctrl.viewer.page.summary import PrimitiveRow, Summary, summarize, tally
from pilegrasp_ctrl.viewer.page.timeline import Timeline, styles, timeline
from pilegrasp_ctrl.viewer.scene.camera import View, view
from pilegrasp_ctrl.viewer.scene.commands import node_path
from pilegrasp_ctrl.viewer.scene.shapes import fingers, paint_of, tubes
from pilegrasp_ctrl.viewer.templates import render, trusted

STATES = {True: "success", False: "failure", None: "unknown"}
"""CSS class of the head for each verdict."""


@dataclass(frozen=True, slots=True, eq=False)
class Panel:
    """A recording with all that its panel is made of."""

    recording: Recording
    summary: Summary
    motions: Sequence[AttemptMotion]
    carried: Sequence[Carried] | None
    events: Sequence[Event]
    lanes: Sequence[Lane]

    @classmethod
    def of(cls, recording: Recording) -> Panel:
        """Measure what the recording does not hold."""
        summary = summarize(recording.meta)
        motions = attempt_motions(recording, summary)
        carried = carried_in(recording) if shows_hand(recording) else None
        return cls(
            recording=recording,
            summary=summary,
            motions=motions,
            carried=carried,
            events=events(recording, summary, carried or (), [motion.separated for motion in motions]),
            lanes=lanes(recording, summary.grasp_force),
        )

    def signals(self) -> bytes:
        """Return all curves of all lanes as a block of bytes, in their order."""
        return signal_block(self.recording.signal_time, [curve.value for lane in self.lanes for curve in lane.curves])


def _quantity(value: float | None, scale: float, pattern: str) -> str:
    return "–" if value is None else format(scale * value, pattern)


def _row(row: PrimitiveRow, style: str) -> dict[str, Any]:
    return {
        "name": plain(row.name),
        "style": style,
        "failed": row.failed,
        "cause": plain(row.trigger) or "–",
        "seek": f"{row.start:.4f}",
        "time": f"{row.start:.2f}–{row.end:.2f}",
        "travel": _quantity(row.travel, 1e3, ".0f"),
        "peak": _quantity(row.peak_force, 1.0, ".1f"),
    }


def _groups(summary: Summary) -> list[dict[str, Any]]:
    """Return the primitives by attempts; one group without a head for a single attempt."""
    rows = list(zip(summary.primitives, styles(summary.primitives), strict=True))
    if not summary.attempts:
        return [{"head": None, "rows": [_row(*row) for row in rows]}]
    starts = [attempt.start for attempt in summary.attempts]
    own: list[list[dict[str, Any]]] = [[] for _ in starts]
    for row, style in rows:
        own[max(0, bisect_right(starts, row.start) - 1)].append(_row(row, style))
    groups = []
    for attempt, found in zip(summary.attempts, own, strict=True):
        head = {
            "number": attempt.number,
            "failed": not attempt.delivered,
            "goal": attempt.goal,
            "held": attempt.held,
            "words": attempt.words,
            "seek": f"{attempt.start:.4f}",
            "time": f"{attempt.start:.1f}–{attempt.end:.1f}",
        }
        groups.append({"head": head, "rows": found})
    return groups


def panel_html(
    panel: Panel, window: tuple[float, float], ranges: Mapping[str, tuple[float, float]], rows: int, with_help: bool
) -> Markup:
    """Return the panel as HTML.

    Args:
        panel: Panel.
        window: First and last time of the timeline [s].
        ranges: Common range of the lanes of each key.
        rows: Least number of rows of the lane of what the hand carried.
        with_help: Whether to explain arrows, marks and keys.
    """
    recording, summary = panel.recording, panel.summary
    paint = {text(name, 40): color for name, color in paint_of(recording).items()}
    shown = Timeline(window, panel.lanes, ranges, panel.events, panel.carried, paint, rows)
    return render(
        "page/panel.html",
        state=STATES[summary.success],
        scenario=summary.scenario,
        seed=f"seed {summary.seed}" if summary.seed else "",
        verdict=summary.verdict,
        reason=summary.reason,
        tally="" if panel.carried is None else tally(count_carried(panel.carried), summary.success),
        facts=summary.facts,
        versions=summary.versions,
        timeline=timeline(shown, summary),
        groups=_groups(summary),
        any_rows=bool(summary.primitives),
        carried=[
            {
                "name": plain(one.object),
                "paint": paint.get(one.object, "none"),
                "start": f"{one.start:.2f}",
                "end": f"{one.end:.2f}",
                "seek": f"{one.end:.4f}",
                "ending": one.ending,
            }
            for one in panel.carried or ()
        ],
        known=panel.carried is not None,
        config=text(json.dumps(recording.meta.get("config"), indent=1, ensure_ascii=False), 20000),
        config_hash=text(recording.meta.get("config_hash"), 80) or "unknown",
        help=trusted("page/help.html") if with_help else "",
    )


def curve_name(lane: Lane, curve: Curve) -> str:
    """Return the name of a curve with its unit, for the head of a table."""
    words = dict.fromkeys(word for word in (lane.title, curve.label) if word)
    return f"{': '.join(words)} [{lane.unit}]"


def panel_data(panel: Panel, shown: View | None = None) -> dict[str, Any]:
    """Return JSON values for the page's script: the clock, the camera, bodies, curves, attempts.

    Args:
        panel: Panel.
        shown: View of the scene; by default the recording's own.
    """
    recording, summary = panel.recording, panel.summary
    paths = [node_path(index, body) for index, body in enumerate(recording.bodies)]
    path_of = dict(zip((body.name for body in recording.bodies), paths, strict=True))
    soft = {index for chain in fingers(recording.bodies) for index in chain}
    times = recording.frame_time
    force = scalar_signal(recording, "push_force")
    tool = signal_at(recording, "tool_position", recording.frame_time)
    column = count()
    return {
        "start": float(times[0]),
        "end": float(times[-1]),
        "view": shown or view(recording),
        "frameTime": np.round(times, 4).tolist(),
        "force": None if force is None else np.round(np.interp(times, recording.signal_time, force), 2).tolist(),
        "primitives": [{"name": plain(row.name), "start": row.start, "end": row.end} for row in summary.primitives],
        "bodies": [
            {"path": path, "name": plain(text(body.name, 40)), "role": body.role, "finger": index in soft}
            for index, (path, body) in enumerate(zip(paths, recording.bodies, strict=True))
        ],
        "objects": [path for path, body in zip(paths, recording.bodies, strict=True) if body.role == "object"],
        "tubes": tubes(recording, paths),
        "tool": None if tool is None else np.round(tool, 4).tolist(),
        "attempts": [
            {
                "start": motion.start,
                "end": motion.end,
                "forward": motion.forward,
                "push": motion.push,
                "separated": {"path": path_of[motion.separated[0]], "time": motion.separated[1]}
                if motion.separated and motion.separated[0] in path_of
                else None,
            }
            for motion in panel.motions
        ],
        "ordered": len(summary.attempts) > 1,
        "lanes": [{"key": lane.key, "columns": [next(column) for _ in lane.curves]} for lane in panel.lanes],
        "curves": [curve_name(lane, curve) for lane in panel.lanes for curve in lane.curves],
        "command": repeat_command(recording.meta),
        "carried": [
            {"name": plain(one.object), "start": one.start, "end": one.end, "ending": one.ending}
            for one in panel.carried or ()
        ],
        "events": [{"time": event.time, "kind": event.kind, "words": event.words} for event in panel.events],
    }
