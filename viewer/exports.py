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
    """Check that the programs that such a file needs are installed, before the work on its content.

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
        path: Path of the file; its suffix decides what the file holds.
        beside: Second recording that the page shows beside the first, on the same clock.
        speed: Speed of a movie, in times real time.
        progress: Function that is called with the number of finished pictures and the number of all.

    Raises:
        ExportError: The suffix is another or does not go with `beside`, a program that the file needs is missing, or
            the place cannot be written.
    """
    suffix = Path(path).suffix
    if beside is not None and suffix != ".html":
        raise ExportError(f"{path}: two recordings stand side by side on a page only; give a name that ends in .html")
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
