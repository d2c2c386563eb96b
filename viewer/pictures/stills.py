"""Still pictures of a recording, drawn by a browser without a window from the page that shows it."""

from __future__ import annotations

import base64
import json
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Self

from pilegrasp_ctrl.exceptions import ExportError
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.viewer.browser import own_script
from pilegrasp_ctrl.viewer.page.document import write_html
from pilegrasp_ctrl.viewer.pictures.chromium import Chromium, require_chromium

Progress = Callable[[int, int], None]
"""A callback that gets the number of finished files or pictures, and the number of all."""

THUMBNAIL_SIZE = (320, 200)
"""Width and height of a thumbnail [px]: twice its size on the page of a study, for screens with small pixels."""


@dataclass(frozen=True, slots=True)
class Moment:
    """A tile of the sheet.

    Attributes:
        time: Moment [s].
        words: Up to two lines of words.
        failed: Whether a primitive failed then.
        near: Whether the tile shows the hand from near.
    """

    time: float
    words: tuple[str, ...]
    failed: bool = False
    near: bool = False


class Stills:
    """A context manager that draws the page that `write_html` writes; pictures are PNG bytes.

    The page's script sets its clock, draws a picture and reads it in one task. A picture therefore depends on its
    moment only, not on how fast the machine draws.

    Raises:
        ExportError: No Chromium is found, or it cannot draw the scene.
    """

    def __init__(self, recording: Recording) -> None:
        executable = require_chromium()
        self._folder = tempfile.TemporaryDirectory(prefix="pilegrasp-")
        self._browser: Chromium | None = None
        try:
            page = Path(self._folder.name) / "attempt.html"
            write_html(recording, page)
            self._browser = Chromium(executable)
            self._browser.open(page)
            _prepare(self._browser)
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the browser and remove the page."""
        if self._browser:
            self._browser.close()
        self._folder.cleanup()

    def _draw(self, method: str, *arguments: Any) -> Any:
        if self._browser is None:
            raise ExportError("the browser that draws the pictures is closed; draw inside the `with` block")
        return self._browser.evaluate(f"picture.{method}({', '.join(map(json.dumps, arguments))})")

    def open_movie(self, width: int, height: int) -> None:
        """Set the size [px] of the frames that follow."""
        self._draw("openMovie", width, height)

    def frame(self, time: float, note: str = "", ink: str = "soft") -> bytes:
        """Return the scene at `time` [s] above the page's words on it and a note in one of the page's colours."""
        return base64.b64decode(self._draw("frame", time, note, ink))

    def open_sheet(self, count: int, head: Mapping[str, str]) -> None:
        """Begin a contact sheet of `count` tiles; `head` holds `title`, `verdict`, `reason` and the verdict's `ink`."""
        self._draw("openSheet", count, dict(head))

    def add_tile(self, index: int, moment: Moment) -> None:
        """Draw a moment of the scene into the sheet's tile `index`, with its words."""
        self._draw("addTile", index, asdict(moment))

    def sheet(self) -> bytes:
        """Return the contact sheet."""
        return base64.b64decode(self._draw("png"))


def thumbnails(pages: Sequence[Path], progress: Progress | None = None) -> list[bytes]:
    """Return a JPEG of the last moment of each page.

    Raises:
        ExportError: No Chromium is found, or it cannot draw.
    """
    pictures: list[bytes] = []
    if not pages:
        return pictures
    with Chromium(require_chromium()) as browser:
        for index, page in enumerate(pages):
            browser.open(page, 640, 480)
            _prepare(browser)
            pictures.append(base64.b64decode(browser.evaluate("picture.thumbnail({}, {})".format(*THUMBNAIL_SIZE))))
            if progress:
                progress(index + 1, len(pages))
    return pictures


def _prepare(browser: Chromium) -> None:
    """Stop the clock of the page that is open, and load the script that draws pictures."""
    if not browser.evaluate("pilegrasp.ready.then(() => Boolean(pilegrasp.viewer))"):
        raise ExportError(
            f"the browser {browser.executable} cannot draw the scene, because WebGL is off in it; use another"
        )
    browser.evaluate("pilegrasp.pause()")
    browser.evaluate(own_script("picture.js") + "undefined")
