"""A recording as page, picture or movie; the name of the file says which."""

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
    """Find out whether the programs that such a file needs are installed, before work is put into what it shows.

    Raises:
        ExportError: where one is missing.
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
        recording: what to show.
        path: of the file; what it holds afterwards follows from its suffix.
        beside: a second recording that the page shows beside the first, on the same clock.
        speed: of a movie, in times real time.
        progress: called with the number of pictures that are done and the number of all.

    Raises:
        ExportError: where the suffix is another or does not go with `beside`, a program that the file needs is missing,
            or the place cannot be written.
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
