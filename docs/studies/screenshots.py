"""Write the pictures of docs/viewer.md.

Usage: python docs/studies/screenshots.py STUDY FOLDER, after `pilegrasp report STUDY`
"""

import base64
from pathlib import Path

from pilegrasp_ctrl.files import RECORDINGS
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.viewer import write_html
from pilegrasp_ctrl.viewer.pictures import chromium
from pilegrasp_ctrl.viewer.study import rows as study_rows
from script import run_script

AT = "(() => { const p = pilegrasp.panels[0].data.primitives[1]; pilegrasp.pause(); pilegrasp.seek(%s); })()"
"""Script that shows a moment of the page, given as a formula of the push `p`."""
PUSHING, GRASPING = AT % "0.2 * p.start + 0.8 * p.end", AT % "p.end + 0.9"
"""Scripts that show the late push, and the hand 0.9 s after it."""
ABOVE = "closeup.click(); pilegrasp.setCamera('above')"
"""Script that looks from above."""
ONLY = (
    "overlays.querySelectorAll('[data-overlay]')"
    ".forEach(b => %s.includes(b.dataset.overlay) === b.checked || b.click())"
)
"""Script that switches on the overlays of a list, and all others off."""


def main(study: Path, folder: Path) -> None:
    """Open the pages of the study's first success and first failure, and write the pictures into FOLDER."""
    rows, pair = reversed(study_rows.read_attempts(study)), study / "pair.html"
    files = {row.success: (study / RECORDINGS / row.stem).with_suffix(".npz") for row in rows}
    write_html(Recording.load(files[True]), pair, Recording.load(files[False]))
    with chromium.Chromium(chromium.require_chromium()) as browser:
        for name, file, width, height, dark, scripts in (
            ("attempt", page := files[True].with_suffix(".html"), 1280, 900, False, [PUSHING]),
            ("motion", page, 1280, 900, False, [ONLY % ["field", "trails"], PUSHING, ABOVE]),
            ("contacts", page, 1280, 900, True, [ONLY % ["contacts", "separated"], GRASPING]),
            ("phone", page, 400, 850, True, [GRASPING]),
            ("pair", pair, 1280, 800, False, [PUSHING]),
            ("study", study / "index.html", 1280, 620, False, []),
        ):
            browser.open(file, width, height)
            browser.resize(width, height, dark)
            for script in ["window.pilegrasp?.ready.then(() => 0)", *scripts]:
                browser.evaluate(script)
            browser.wait_for_picture()
            picture = browser.call("Page.captureScreenshot", format="jpeg", quality=70)["data"]
            (folder / f"{name}.jpg").write_bytes(base64.b64decode(picture))


if __name__ == "__main__":
    run_script(main)
