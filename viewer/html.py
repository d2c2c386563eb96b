"""The page: meshcat's own viewer, the packed scene, the strips and the verdict in one file without a server."""

from __future__ import annotations

import base64
import hashlib
import importlib.util
import json
import os
from html import escape
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from pilegrasp_ctrl.exceptions import ExportError
from pilegrasp_ctrl.recording import Recording, write_atomically
from pilegrasp_ctrl.viewer.camera import view
from pilegrasp_ctrl.viewer.commands import commands, pack
from pilegrasp_ctrl.viewer.plots import controller_strips, force_strip, scalar_signal, styles
from pilegrasp_ctrl.viewer.summary import Phase, Summary, plain, summarize, text

_HERE = Path(__file__).parent


def viewer_script() -> str:
    """Return meshcat's viewer with its licences; it is read from the installed package, which is not imported.

    Raises:
        ExportError: where meshcat is not installed or carries no viewer.
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
    # The page names no address, so a reader can see at a glance that it asks for nothing.
    licence = licence.replace("https://", "").replace("http://", "").replace("*/", "").replace("/*", "")
    return f"/*!\nmeshcat and what it bundles:\n{licence}\n*/\n{script}"


def own_script(*names: str) -> str:
    """Return scripts of this folder, one after the other."""
    return "".join((_HERE / name).read_text(encoding="utf-8") for name in names)


def _json(value: Any) -> str:
    """Return JSON that cannot end the script element it stands in."""
    return json.dumps(value, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def _live(recording: Recording, summary: Summary) -> dict[str, Any]:
    """Return what the page's script needs: clock, camera, force at each frame, phases."""
    start, end = float(recording.frame_time[0]), float(recording.frame_time[-1])
    force = scalar_signal(recording, "push_force")
    times = recording.frame_time
    return {
        "start": start,
        "end": end,
        "view": view(recording),
        "frameTime": np.round(times, 4).tolist(),
        "force": None if force is None else np.round(np.interp(times, recording.signal_time, force), 2).tolist(),
        "phases": [{"name": p.name, "start": p.start, "end": p.end} for p in summary.phases],
    }


def _quantity(value: float | None, scale: float, pattern: str) -> str:
    return "–" if value is None else format(scale * value, pattern)


def _row(phase: Phase, style: str) -> str:
    cause = escape(plain(phase.trigger)) or "–"
    return (
        f'<tr class="{"failed" if phase.failed else ""}"><th scope="row">'
        f'<button type="button" data-seek="{phase.start:.4f}"><i class="chip {style}"></i>'
        f"{escape(phase.name)}</button></th>"
        f"<td>{'failed: ' if phase.failed else ''}{cause}</td><td>{phase.start:.2f}–{phase.end:.2f}</td>"
        f"<td>{_quantity(phase.travel, 1e3, '.0f')}</td><td>{_quantity(phase.peak_force, 1.0, '.1f')}</td></tr>"
    )


def _pairs(pairs: tuple[tuple[str, str], ...]) -> str:
    return "".join(f"<div><dt>{escape(name)}</dt><dd>{escape(value)}</dd></div>" for name, value in pairs)


def page(recording: Recording) -> str:
    """Return the recording as one HTML document that loads nothing from anywhere.

    Equal recordings give equal pages. The document's own policy forbids every request and every script but its three.

    Raises:
        ExportError: where meshcat's viewer is missing.
    """
    summary = summarize(recording.meta)
    scripts = (viewer_script(), own_script("stage.js", "page.js"))
    hashes = (base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in scripts)
    rows = "".join(_row(phase, style) for phase, style in zip(summary.phases, styles(summary.phases), strict=True))
    state = {True: "success", False: "failure", None: "unknown"}[summary.success]
    return Template((_HERE / "page.html").read_text(encoding="utf-8")).substitute(
        policy="; ".join(
            (
                "default-src 'none'",
                "script-src " + " ".join(f"'sha256-{digest}'" for digest in hashes),
                "style-src 'unsafe-inline'",
                "img-src data: blob:",
            )
        ),
        title=escape(f"{summary.scenario}{f', seed {summary.seed}' if summary.seed else ''}: {summary.verdict}"),
        style=(_HERE / "page.css").read_text(encoding="utf-8"),
        scenario=escape(summary.scenario),
        seed=escape(f"seed {summary.seed}" if summary.seed else ""),
        state=state,
        verdict=escape(summary.verdict),
        reason=escape(summary.reason),
        strip=force_strip(recording, summary.phases, summary.grasp_force),
        rows=rows or '<tr><td colspan="5">No primitives were recorded.</td></tr>',
        facts=_pairs(summary.facts),
        controller=controller_strips(recording, summary.phases) or "<p>No controller signals were recorded.</p>",
        # Where no force ends the motion, how well it was followed is what there is to see.
        open="open" if summary.grasp_force is None else "",
        versions=_pairs(summary.versions),
        config=escape(text(json.dumps(recording.meta.get("config"), indent=1, ensure_ascii=False), 20000)),
        config_hash=escape(text(recording.meta.get("config_hash"), 80) or "unknown"),
        data=_json(_live(recording, summary)),
        commands=base64.b64encode(pack(commands(recording))).decode(),
        viewer=scripts[0],
        script=scripts[1],
    )


def write_html(recording: Recording, path: str | os.PathLike[str]) -> None:
    """Write `page(recording)` to a file, all of it or nothing.

    Raises:
        ExportError: where the place cannot be written or meshcat's viewer is missing.
    """
    content = page(recording).encode("utf-8", errors="replace")
    try:
        write_atomically(Path(path), content)
    except (OSError, ValueError) as error:
        raise ExportError(f"the page cannot be written to {str(path)!r}: {error}") from error
