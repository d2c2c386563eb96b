"""The page: meshcat's viewer, the packed scene, the timeline and the verdict in one file without a server."""

from __future__ import annotations

import base64
import hashlib
import importlib.util
import json
import os
import zlib
from html import escape
from pathlib import Path
from string import Template
from typing import Any

from pilegrasp_ctrl.exceptions import ExportError
from pilegrasp_ctrl.files import write_whole
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.viewer.commands import commands, pack
from pilegrasp_ctrl.viewer.motion import with_motion
from pilegrasp_ctrl.viewer.overlays import contact_block
from pilegrasp_ctrl.viewer.panel import panel_data, panel_html
from pilegrasp_ctrl.viewer.summary import Summary, summarize

MAX_FRAMES = 50_000
"""Largest number of frames in a page: 28 minutes at 30 Hz; chosen. A browser does not open a much longer page."""

_HERE = Path(__file__).parent


def viewer_script() -> str:
    """Return meshcat's viewer with its licences, read from the installed package without importing it.

    Raises:
        ExportError: Meshcat is not installed or has no viewer.
    """
    spec = importlib.util.find_spec("meshcat")
    if spec is None or spec.origin is None:
        raise ExportError("the page needs meshcat's viewer; install it with `pip install meshcat`")
    folder = Path(spec.origin).parent / "viewer"
    try:
        script = (folder / "dist" / "main.min.js").read_text(encoding="utf-8")
    except OSError as error:
        raise ExportError(f"meshcat's viewer cannot be read: {error}; install meshcat 0.3.2 again") from error
    notices = [folder / "LICENSE", folder / "dist" / "main.min.js.LICENSE.txt"]
    licence = "\n".join(file.read_text(encoding="utf-8") for file in notices if file.is_file())
    # The page contains no address, which shows a reader that it loads nothing.
    licence = licence.replace("https://", "").replace("http://", "").replace("*/", "").replace("/*", "")
    return f"/*!\nmeshcat and what it bundles:\n{licence}\n*/\n{script}"


def own_script(*names: str) -> str:
    """Return the joined text of scripts in this folder."""
    return "".join((_HERE / name).read_text(encoding="utf-8") for name in names)


def _json(value: Any) -> str:
    """Return JSON that cannot end its script element."""
    return json.dumps(value, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def _block(name: str, content: bytes) -> str:
    """Return compressed bytes as a script element that no browser runs."""
    encoded = base64.b64encode(zlib.compress(content, 9)).decode()
    return f'<script type="application/octet-stream" class="{name}">{encoded}</script>'


def page(recording: Recording, beside: Recording | None = None) -> str:
    """Return the recording as one HTML document that loads nothing.

    A second recording is shown beside the first, on the same clock. A recording without a motion pattern is measured
    first. Equal recordings give equal pages. The document's policy forbids every request and every script but its two.

    Raises:
        ExportError: Meshcat's viewer is missing, or a recording is too long for a page.
    """
    given = (recording,) if beside is None else (recording, beside)
    for shown in given:
        if shown.frame_time.size > MAX_FRAMES:
            raise ExportError(
                f"the recording holds {shown.frame_time.size} frames, and a page plays {MAX_FRAMES} at most; "
                "record an attempt that is shorter"
            )
    recordings = tuple(map(with_motion, given))
    summaries = [summarize(shown.meta) for shown in recordings]
    window = (
        min(float(shown.frame_time[0]) for shown in recordings),
        max(float(shown.frame_time[-1]) for shown in recordings),
    )
    scripts = (viewer_script(), own_script("scene_view.js", "tubes.js", "overlays.js", "panel.js", "page.js"))
    hashes = (base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in scripts)
    return Template((_HERE / "page.html").read_text(encoding="utf-8")).substitute(
        policy="; ".join(
            (
                "default-src 'none'",
                "script-src " + " ".join(f"'sha256-{digest}'" for digest in hashes),
                "style-src 'unsafe-inline'",
                "img-src data: blob:",
            )
        ),
        title=escape(" | ".join(map(_title, summaries))),
        style=(_HERE / "page.css").read_text(encoding="utf-8"),
        kind="single" if beside is None else "pair",
        panels="".join(
            panel_html(shown, summary, window, with_help=shown is recordings[-1])
            for shown, summary in zip(recordings, summaries, strict=True)
        ),
        data=_json([panel_data(shown, summary) for shown, summary in zip(recordings, summaries, strict=True)]),
        blocks="".join(
            _block("commands", pack(commands(shown))) + _block("contacts", contact_block(shown)) for shown in recordings
        ),
        viewer=scripts[0],
        script=scripts[1],
    )


def _title(summary: Summary) -> str:
    return f"{summary.scenario}{f', seed {summary.seed}' if summary.seed else ''}: {summary.verdict}"


def write_html(recording: Recording, path: str | os.PathLike[str], beside: Recording | None = None) -> None:
    """Write `page(recording, beside)` to a file, all of it or nothing.

    Raises:
        ExportError: The path cannot be written, meshcat's viewer is missing, or a recording is too long.
    """
    content = page(recording, beside).encode("utf-8", errors="replace")
    try:
        write_whole(Path(path), content)
    except (OSError, ValueError) as error:
        raise ExportError(f"the page cannot be written to {str(path)!r}: {error}") from error
