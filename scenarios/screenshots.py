"""The pictures of docs/viewer.md: `python scenarios/screenshots.py STUDY FOLDER`, after `pilegrasp report STUDY`."""

import base64
from pathlib import Path

from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.scenarios._script import run_script
from pilegrasp_ctrl.viewer import write_html
from pilegrasp_ctrl.viewer.chromium import Chromium, require_chromium
from pilegrasp_ctrl.viewer.index_rows import RECORDINGS, read_attempts

AT = "(() => { const p = pilegrasp.panels[0].data.phases[1]; pilegrasp.pause(); pilegrasp.seek(%s); })()"
PUSHING, GRASPING = AT % "0.2 * p.start + 0.8 * p.end", AT % "p.end + 0.9"
ONLY = "overlays.querySelectorAll('input').forEach(b => %s.includes(b.dataset.overlay) === b.checked || b.click())"


def main(study: Path, folder: Path) -> None:
    """Show the study's first success and first failure, and write the pictures into FOLDER."""
    stems = {row.success: study / RECORDINGS / row.stem for row in reversed(read_attempts(study))}
    page, pair = stems[True].with_suffix(".html"), study / "pair.html"
    success, failure = (Recording.load(stems[verdict].with_suffix(".npz")) for verdict in (True, False))
    write_html(success, pair, failure)
    pictures: list[tuple[str, Path, int, int, bool, list[str]]] = [
        ("attempt", page, 1280, 900, False, [PUSHING]),
        ("motion", page, 1280, 900, False, [ONLY % ["field", "trails"], PUSHING, "above.click()"]),
        ("contacts", page, 1280, 900, True, [ONLY % ["contacts", "separated"], GRASPING]),
        ("phone", page, 400, 850, True, [GRASPING]),
        ("pair", pair, 1280, 800, False, [PUSHING]),
        ("study", study / "index.html", 1280, 620, False, []),
    ]
    with Chromium(require_chromium()) as browser:
        for name, file, width, height, dark, scripts in pictures:
            browser.open(file, width, height)
            browser.resize(width, height, dark)
            for script in ["window.pilegrasp?.ready.then(() => 0)", *scripts]:
                browser.evaluate(script)
            browser.wait_for_picture()
            picture = browser.call("Page.captureScreenshot", format="jpeg", quality=70)
            (folder / f"{name}.jpg").write_bytes(base64.b64decode(picture["data"]))


if __name__ == "__main__":
    run_script(main)
