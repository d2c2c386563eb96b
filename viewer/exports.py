"""Writing a recording as page, picture or movie; the name of the file decides."""

from __future__ import annotations

import os
from pathlib import Path

from pilegrasp_ctrl.exceptions import ExportError
from pilegrasp_ctrl.files import VIEWS
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.viewer.chromium import require_chromium
from pilegrasp_ctrl.viewer.contact_sheet import write_png
from pilegrasp_ctrl.viewer.html import write_html
from pilegrasp_ctrl.viewer.movie import require_ffmpeg, write_gif, write_mp4
from pilegrasp_ctrl.viewer.stills import Progress


def require_programs(path: str | os.PathLike[str]) -> None:
    """Check that the programs for such a file are installed, before its content is made.

    Raises:
        ExportError: A program is missing.
    """
    suffix = Path(path).suffix
    if suffix != ".html":
        require_chromium()
    if suffix == ".mp4":
        require_ffmpeg()


def write(
    recording: Recording,
    path: str | os.PathLike[str],
    *,
    beside: Recording | None = None,
    speed: float = 1.0,
    progress: Progress | None = None,
) -> None:
    """Write a recording to a file: page (.html), contact sheet (.png) or movie (.gif, .mp4), all of it or nothing.

    Args:
        recording: Recording to show.
        path: Path of the file; its suffix decides the format.
        beside: Second recording that the page shows beside the first, on the same clock.
        speed: Speed of a movie, in times real time.
        progress: Callback that gets the number of finished pictures and the number of all pictures.

    Raises:
        ExportError: The suffix is unknown or does not fit `beside`, a program for the file is missing, or the path
            cannot be written.
    """
    suffix = Path(path).suffix
    if beside is not None and suffix != ".html":
        raise ExportError(f"{path}: only a page shows two recordings side by side; give a name that ends in .html")
    match suffix:
        case ".html":
            write_html(recording, path, beside)
        case ".png":
            write_png(recording, path, progress)
        case ".gif":
            write_gif(recording, path, speed, progress)
        case ".mp4":
            write_mp4(recording, path, speed, progress)
        case _:
            raise ExportError(f"{path}: the name must end in {', '.join(VIEWS[:-1])} or {VIEWS[-1]}")
