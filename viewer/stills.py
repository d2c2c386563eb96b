"""The page of a recording in a browser without a window, held at moments of its own clock."""

from __future__ import annotations

import base64
import json
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Self

from pilegrasp_ctrl.exceptions import ExportError
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.viewer.chromium import Chromium, require_chromium
from pilegrasp_ctrl.viewer.html import own_script, write_html

Progress = Callable[[int, int], None]
"""Called with the number of pictures that are done and the number of all."""


class Stills:
    """A context manager that draws the very page that `write_html` writes; pictures are PNG bytes.

    Each picture is drawn and read in one task of the page's script after its clock was set, so what it shows depends on
    the moment only, not on how fast the machine draws.

    Raises:
        ExportError: where no Chromium is found, or it cannot draw the scene.
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
            if not self._browser.evaluate("pilegrasp.ready.then(() => Boolean(pilegrasp.viewer))"):
                raise ExportError(f"the browser {executable} cannot draw the scene, as WebGL is off in it; use another")
            self._browser.evaluate("pilegrasp.pause()")
            self._browser.evaluate(own_script("picture.js") + "undefined")
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
        assert self._browser is not None
        return self._browser.evaluate(f"picture.{method}({', '.join(map(json.dumps, arguments))})")

    def open_movie(self, width: int, height: int) -> None:
        """Set the size [px] of the frames that follow."""
        self._draw("openMovie", width, height)

    def frame(self, time: float, note: str = "", ink: str = "soft") -> bytes:
        """Return the scene at `time` [s] with the page's words on it below, and a note in one of the page's colours."""
        return base64.b64decode(self._draw("frame", time, note, ink))

    def open_sheet(self, count: int, head: Mapping[str, str]) -> None:
        """Begin a contact sheet of `count` tiles; `head` holds `title`, `verdict`, `reason` and the verdict's `ink`."""
        self._draw("openSheet", count, dict(head))

    def add_tile(self, index: int, time: float, words: tuple[str, ...], failed: bool = False) -> None:
        """Draw the scene at `time` [s] into the sheet's tile `index`, with up to two lines of words."""
        self._draw("addTile", index, {"time": time, "words": list(words), "failed": failed})

    def sheet(self) -> bytes:
        """Return the contact sheet."""
        return base64.b64decode(self._draw("png"))
