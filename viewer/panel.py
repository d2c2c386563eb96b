"""One attempt on a page: head, scene, timeline and table as HTML, and the values that the page's script needs."""

from __future__ import annotations

import json
from html import escape
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from pilegrasp_ctrl.analysis.reading import plain, signal_at, text
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.viewer.camera import view
from pilegrasp_ctrl.viewer.commands import node_path
from pilegrasp_ctrl.viewer.lane import scalar_signal
from pilegrasp_ctrl.viewer.motion import forward, push_frame
from pilegrasp_ctrl.viewer.shapes import tubes
from pilegrasp_ctrl.viewer.summary import PrimitiveRow, Summary, separated
from pilegrasp_ctrl.viewer.timeline import styles, timeline

_HERE = Path(__file__).parent
STATES = {True: "success", False: "failure", None: "unknown"}
"""CSS class of the head for each verdict."""


def _quantity(value: float | None, scale: float, pattern: str) -> str:
    return "–" if value is None else format(scale * value, pattern)


def _row(row: PrimitiveRow, style: str) -> str:
    cause = escape(plain(row.trigger)) or "–"
    return (
        f'<tr class="{"failed" if row.failed else ""}"><th scope="row">'
        f'<button type="button" data-seek="{row.start:.4f}"><i class="chip {style}"></i>'
        f"{escape(row.name)}</button></th>"
        f"<td>{'failed: ' if row.failed else ''}{cause}</td><td>{row.start:.2f}–{row.end:.2f}</td>"
        f"<td>{_quantity(row.travel, 1e3, '.0f')}</td><td>{_quantity(row.peak_force, 1.0, '.1f')}</td></tr>"
    )


def _pairs(pairs: tuple[tuple[str, str], ...]) -> str:
    return "".join(f"<div><dt>{escape(name)}</dt><dd>{escape(value)}</dd></div>" for name, value in pairs)


def panel_html(recording: Recording, summary: Summary, window: tuple[float, float], with_help: bool) -> str:
    """Return the panel as HTML; its timeline shows the window between two times [s]."""
    rows = "".join(_row(row, style) for row, style in zip(summary.primitives, styles(summary.primitives), strict=True))
    return Template((_HERE / "panel.html").read_text(encoding="utf-8")).substitute(
        state=STATES[summary.success],
        scenario=escape(summary.scenario),
        seed=escape(f"seed {summary.seed}" if summary.seed else ""),
        verdict=escape(summary.verdict),
        reason=escape(summary.reason),
        facts=_pairs(summary.facts),
        versions=_pairs(summary.versions),
        timeline=timeline(recording, summary, window),
        rows=rows or '<tr><td colspan="5">No primitives were recorded.</td></tr>',
        config=escape(text(json.dumps(recording.meta.get("config"), indent=1, ensure_ascii=False), 20000)),
        config_hash=escape(text(recording.meta.get("config_hash"), 80) or "unknown"),
        help=(_HERE / "help.html").read_text(encoding="utf-8") if with_help else "",
    )


def panel_data(recording: Recording, summary: Summary) -> dict[str, Any]:
    """Return JSON values for the page's script: the clock, the camera, forces, paths in the scene tree, overlays."""
    paths = [node_path(index, body) for index, body in enumerate(recording.bodies)]
    names = [body.name for body in recording.bodies]
    times = recording.frame_time
    force = scalar_signal(recording, "push_force")
    tool = signal_at(recording, "tool_position", recording.frame_time)
    apart = separated(recording.meta)
    return {
        "start": float(times[0]),
        "end": float(times[-1]),
        "view": view(recording),
        "frameTime": np.round(times, 4).tolist(),
        "force": None if force is None else np.round(np.interp(times, recording.signal_time, force), 2).tolist(),
        "primitives": [{"name": row.name, "start": row.start, "end": row.end} for row in summary.primitives],
        "objects": [path for path, body in zip(paths, recording.bodies, strict=True) if body.role == "object"],
        "tubes": tubes(recording, paths),
        "forward": forward(recording),
        "push": push_frame(recording),
        "tool": None if tool is None else np.round(tool, 4).tolist(),
        "separated": {"path": paths[names.index(apart[0])], "time": apart[1]} if apart and apart[0] in names else None,
    }
