"""Writing a recording as page, picture, movie or log; the name of the file decides."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from pilegrasp_ctrl.exceptions import ExportError
from pilegrasp_ctrl.files import VIEWS
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.viewer.logs.mcap_log import require_mcap, write_mcap
from pilegrasp_ctrl.viewer.logs.rerun_log import require_rerun, write_rrd
from pilegrasp_ctrl.viewer.logs.signal_table import write_csv
from pilegrasp_ctrl.viewer.page.document import write_html
from pilegrasp_ctrl.viewer.pictures.chromium import require_chromium
from pilegrasp_ctrl.viewer.pictures.contact_sheet import write_png
from pilegrasp_ctrl.viewer.pictures.movie import require_ffmpeg, write_gif, write_mp4
from pilegrasp_ctrl.viewer.pictures.stills import Progress

Writer = Callable[[Recording, str | os.PathLike[str], float, Progress | None], None]
"""Writes a recording to a path, a movie at a speed in times real time, with a callback after each picture."""


class Format(NamedTuple):
    """A form of a recording.

    Attributes:
        write: Writer of the file.
        requires: Checks, each of which raises `ExportError` where a program or package is missing.
    """

    write: Writer
    requires: tuple[Callable[[], object], ...] = ()


FORMATS: dict[str, Format] = {
    ".html": Format(lambda recording, path, speed, progress: write_html(recording, path)),
    ".png": Format(lambda recording, path, speed, progress: write_png(recording, path, progress), (require_chromium,)),
    ".gif": Format(write_gif, (require_chromium,)),
    ".mp4": Format(write_mp4, (require_ffmpeg, require_chromium)),
    ".csv": Format(lambda recording, path, speed, progress: write_csv(recording, path)),
    ".rrd": Format(lambda recording, path, speed, progress: write_rrd(recording, path), (require_rerun,)),
    ".mcap": Format(lambda recording, path, speed, progress: write_mcap(recording, path), (require_mcap,)),
}
"""Form of a recording for each suffix of `VIEWS`."""


def require_programs(path: str | os.PathLike[str]) -> None:
    """Check that the programs for such a file are installed, before its content is made.

    Raises:
        ExportError: A program or package is missing.
    """
    for require in FORMATS[Path(path).suffix].requires:
        require()


def write(
    recording: Recording,
    path: str | os.PathLike[str],
    *,
    beside: Recording | None = None,
    speed: float = 1.0,
    progress: Progress | None = None,
    embed_recording: bool = False,
    sources: Sequence[str] = (),
) -> None:
    """Write a recording to a file, all of it or nothing.

    The suffix of the path decides: a page (.html), a contact sheet (.png), a movie (.gif, .mp4), the signals as a table
    (.csv), or a log for Rerun (.rrd) or Foxglove (.mcap).

    Args:
        recording: Recording to show.
        path: Path of the file; its suffix decides the format.
        beside: Second recording that the page shows beside the first, on the same clock.
        speed: Speed of a movie, in times real time.
        progress: Callback that gets the number of finished pictures and the number of all pictures.
        embed_recording: Whether a page holds the recordings themselves.
        sources: Addresses of the recordings' files, relative to a page, to which it links.

    Raises:
        ExportError: The suffix is unknown or does not fit `beside`, a program for the file is missing, or the path
            cannot be written.
    """
    suffix = Path(path).suffix
    if suffix not in FORMATS:
        raise ExportError(f"{path}: the name must end in {', '.join(VIEWS[:-1])} or {VIEWS[-1]}")
    if suffix == ".html":
        write_html(recording, path, beside, embed_recording=embed_recording, sources=sources)
    elif beside is not None:
        raise ExportError(f"{path}: only a page shows two recordings side by side; give a name that ends in .html")
    elif embed_recording:
        raise ExportError(f"{path}: only a page can hold the recording; give a name that ends in .html")
    else:
        FORMATS[suffix].write(recording, path, speed, progress)
