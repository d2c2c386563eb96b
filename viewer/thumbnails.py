"""Small pictures of recorded attempts, drawn by one browser without a window from the pages that show them."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from pathlib import Path

from pilegrasp_ctrl.viewer.chromium import Chromium, require_chromium
from pilegrasp_ctrl.viewer.html import own_script
from pilegrasp_ctrl.viewer.stills import Progress

SIZE = (320, 200)
"""Width and height [px]: twice what the page of a study shows, for screens with small pixels."""


def thumbnails(pages: Sequence[Path], progress: Progress | None = None) -> list[bytes]:
    """Return a JPEG of the last moment of each page.

    Raises:
        ExportError: where no Chromium is found, or it cannot draw.
    """
    pictures: list[bytes] = []
    if not pages:
        return pictures
    with Chromium(require_chromium()) as browser:
        for index, page in enumerate(pages):
            browser.open(page, 640, 480)
            browser.evaluate("pilegrasp.ready.then(() => pilegrasp.pause())")
            browser.evaluate(own_script("picture.js") + "undefined")
            pictures.append(base64.b64decode(browser.evaluate(f"picture.thumbnail({SIZE[0]}, {SIZE[1]})")))
            if progress:
                progress(index + 1, len(pages))
    return pictures
