"""The page: meshcat's viewer, the packed scene, the timeline and the verdict in one file without a server."""

from __future__ import annotations

import base64
import json
import os
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

from markupsafe import Markup, escape

from pilegrasp_ctrl.exceptions import ExportError
from pilegrasp_ctrl.files import write_whole
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.viewer.browser import PAGE_SCRIPTS, digest, own_script, viewer_script
from pilegrasp_ctrl.viewer.page.command import repeat_command
from pilegrasp_ctrl.viewer.page.lanes import common_ranges
from pilegrasp_ctrl.viewer.page.limits import check_size
from pilegrasp_ctrl.viewer.page.panel import Panel, panel_data, panel_html
from pilegrasp_ctrl.viewer.page.summary import Summary
from pilegrasp_ctrl.viewer.page.timeline import rows_of
from pilegrasp_ctrl.viewer.scene.camera import joined, view
from pilegrasp_ctrl.viewer.scene.commands import commands, pack
from pilegrasp_ctrl.viewer.scene.overlays import contact_block
from pilegrasp_ctrl.viewer.templates import render, trusted

FRAME_HEIGHT = 620
"""Height of a page in a notebook [px]; chosen."""


def _json(value: Any) -> Markup:
    """Return JSON that cannot end its script element."""
    return Markup(json.dumps(value, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c"))


def _block(name: str, content: bytes) -> Markup:
    """Return compressed bytes as a script element that no browser runs."""
    return _raw(name, zlib.compress(content, 9))


def _raw(name: str, content: bytes) -> Markup:
    """Return bytes as a script element that no browser runs."""
    encoded = base64.b64encode(content).decode()
    return Markup('<script type="application/octet-stream" class="{}">{}</script>').format(name, Markup(encoded))


def page(
    recording: Recording,
    beside: Recording | None = None,
    *,
    embed_recording: bool = False,
    sources: Sequence[str] = (),
    compact: bool = False,
    viewer: str = "",
) -> str:
    """Return the recording as one HTML document that loads nothing.

    A second recording is shown beside the first, on the same clock and to the same scales. A recording without a motion
    pattern is measured first. Equal recordings give equal pages. The document's policy forbids every request and every
    script but its two.

    Args:
        recording: Recording to show.
        beside: Second recording.
        embed_recording: Whether the page holds the recordings themselves, for its reader to save.
        sources: Addresses of the recordings' files, relative to the page, to which it links.
        compact: Whether to leave out parameters and tables, as a page inside another one does.
        viewer: Address of a file with `viewer_script()`, relative to the page, which the page loads in place of holding
            it. Its policy then allows scripts of its own folder and of files.

    Raises:
        ExportError: Meshcat's viewer is missing, or a recording holds more than a page shows.
    """
    recordings = (recording,) if beside is None else (recording, beside)
    for shown in recordings:
        check_size(shown)
    panels = [Panel.of(shown) for shown in recordings]
    window = (
        min(float(shown.frame_time[0]) for shown in recordings),
        max(float(shown.frame_time[-1]) for shown in recordings),
    )
    ranges = common_ranges([panel.lanes for panel in panels])
    rows = max((1 + row for panel in panels for row in rows_of(panel.carried or ())), default=1)
    common = None if beside is None else joined([view(shown) for shown in recordings])
    scripts = (viewer_script(), own_script(*PAGE_SCRIPTS))
    allowed = ["'self' file:", digest(scripts[1])] if viewer else list(map(digest, scripts))
    document = render(
        "page/page.html",
        policy="; ".join(
            (
                "default-src 'none'",
                "script-src " + " ".join(allowed),
                "style-src 'unsafe-inline'",
                "img-src data: blob:",
            )
        ),
        title=" | ".join(_title(panel.summary) for panel in panels),
        style=trusted("page/page.css"),
        kind="single" if beside is None else "pair",
        panels=[panel_html(panel, window, ranges, rows, with_help=panel is panels[-1]) for panel in panels],
        signals=list(dict.fromkeys((lane.key, lane.title, lane.shown) for panel in panels for lane in panel.lanes)),
        data=_json([panel_data(panel, common) for panel in panels]),
        blocks=[
            _block(name, content)
            for panel in panels
            for name, content in (
                ("commands", pack(commands(panel.recording, [row.start for row in panel.summary.attempts]))),
                ("contacts", contact_block(panel.recording)),
                ("signals", panel.signals()),
            )
        ]
        + [_raw("recording", shown.to_bytes()) for shown in recordings if embed_recording],
        compact=compact,
        embedded=embed_recording,
        sources=[quote(source) for source in sources],
        commands=any(repeat_command(shown.meta) for shown in recordings),
        shared_viewer=quote(viewer),
        viewer="" if viewer else Markup(scripts[0]),
        script=Markup(scripts[1]),
    )
    return str(document)


def frame(recording: Recording) -> str:
    """Return the compact page in an `iframe` element, as a notebook shows it."""
    document = escape(page(recording, compact=True))
    return f'<iframe srcdoc="{document}" style="width:100%;height:{FRAME_HEIGHT}px;border:0"></iframe>'


def _title(summary: Summary) -> str:
    return f"{summary.scenario}{f', seed {summary.seed}' if summary.seed else ''}: {summary.verdict}"


def write_html(
    recording: Recording,
    path: str | os.PathLike[str],
    beside: Recording | None = None,
    *,
    embed_recording: bool = False,
    sources: Sequence[str] = (),
    viewer: str = "",
) -> None:
    """Write `page(recording, beside, ...)` to a file, all of it or nothing.

    Raises:
        ExportError: The path cannot be written, meshcat's viewer is missing, or a recording holds more than a page
            shows.
    """
    document = page(recording, beside, embed_recording=embed_recording, sources=sources, viewer=viewer)
    content = document.encode("utf-8", errors="replace")
    try:
        write_whole(Path(path), content)
    except (OSError, ValueError) as error:
        raise ExportError(f"the page cannot be written to {str(path)!r}: {error}") from error
