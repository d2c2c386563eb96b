"""Size and time of the pages of synthetic attempts, and of the kept study's page, as two tables.

    python tests/helpers/measure_pages.py [--study]

With `--study`, the page of the study alone.
"""

from __future__ import annotations

import lzma
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from browser import Browser, find_chromium
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.recording_parts import Contacts
from pilegrasp_ctrl.statistics import markdown_row, markdown_table
from pilegrasp_ctrl.viewer import write_html
from pilegrasp_ctrl.viewer.study.page import index_page
from pilegrasp_ctrl.viewer.study.rows import read_attempts
from synthetic_recording import synthetic

KEPT = Path(__file__).parents[2] / "docs" / "results" / "study.db.xz"
"""The study that docs/results shows."""


def repeated(once: Recording, cycles: int) -> Recording:
    """Return the attempt several times in a row."""
    period = float(once.frame_time[-1] - once.frame_time[0]) + 1.0 / 30.0

    def times(array: np.ndarray) -> np.ndarray:
        return np.tile(array, cycles) + np.repeat(np.arange(cycles) * period, array.size)

    contacts = once.contacts
    return replace(
        once,
        frame_time=times(once.frame_time),
        body_position=np.tile(once.body_position, (cycles, 1, 1)),
        body_quaternion=np.tile(once.body_quaternion, (cycles, 1, 1)),
        signal_time=times(once.signal_time),
        signals={name: np.tile(signal, (cycles,) + (1,) * (signal.ndim - 1)) for name, signal in once.signals.items()},
        contacts=contacts
        and Contacts(
            np.concatenate([[0], np.cumsum(np.tile(np.diff(contacts.start), cycles))]),
            *(np.tile(getattr(contacts, name), (cycles, 1)) for name in ("bodies", "position", "force")),
        ),
    )


SCROLLED = """(async () => {
  const pane = document.querySelector(".pane.tall");
  pane.scrollIntoView();
  const begun = performance.now();
  for (let step = 1; step <= 20; step++) {
    pane.scrollTop = (step * pane.scrollHeight) / 20;
    await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
  }
  return (performance.now() - begun) / 20;
})()"""
"""Script that scrolls through all attempts in 20 steps; it returns the time of a step [ms], two pictures each."""


def measure_study() -> None:
    """Print size, processor time of the page, time until it is drawn, and time of a step of scrolling.

    The processor's time is that of the page's thread, which other programs do not lengthen.
    """
    executable = find_chromium()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        (folder / "study.db").write_bytes(lzma.decompress(KEPT.read_bytes()))
        rows = read_attempts(folder)
        begun = time.process_time()
        (folder / "index.html").write_text(index_page("study", rows), encoding="utf-8")
        exported = time.process_time() - begun
        opened = work = scrolled = ""
        if executable:
            with Browser(executable) as browser:
                browser.call("Performance.enable", timeDomain="threadTicks")
                browser.open(folder / "index.html")
                opened = f"{browser.evaluate('performance.now()') / 1e3:.1f}"
                metrics = browser.call("Performance.getMetrics")["metrics"]
                (work,) = (f"{one['value']:.1f}" for one in metrics if one["name"] == "TaskDuration")
                scrolled = f"{browser.evaluate(SCROLLED):.0f}"
        size = (folder / "index.html").stat().st_size / 1e6
    head = ("page [MB]", "export, processor [s]", "opened [s]", "opened, processor [s]", "a step of scrolling [ms]")
    print(markdown_table(("study", *head)))
    print(markdown_row((f"{len(rows)} attempts", f"{size:.2f}", f"{exported:.2f}", opened, work, scrolled)))


def main() -> None:
    """Print both tables."""
    if "--study" not in sys.argv:
        measure_recordings()
        print()
    measure_study()


def measure_recordings() -> None:
    """Print size, processor time of the export, and time until the scene is drawn, for three recordings."""
    recordings = {
        "10 s, 25 objects": synthetic(objects=25),
        "10 s, 90 objects": synthetic(objects=90),
        "5 minutes, 18 objects": repeated(synthetic(objects=18), 30),
    }
    executable = find_chromium()
    print(markdown_table(("recording", "frames", "bodies", "page [MB]", "export, processor [s]", "opened [s]")))
    for name, recording in recordings.items():
        with tempfile.TemporaryDirectory() as folder:
            page = Path(folder) / "page.html"
            begun = time.process_time()
            write_html(recording, page)
            exported = time.process_time() - begun
            opened = ""
            if executable:
                with Browser(executable) as browser:
                    browser.open(page)
                    opened = f"{browser.evaluate('pilegrasp.drawn') / 1e3:.1f}"
            size = page.stat().st_size / 1e6
        count = (recording.frame_time.size, len(recording.bodies))
        print(markdown_row((name, *count, f"{size:.2f}", f"{exported:.2f}", opened)), flush=True)


if __name__ == "__main__":
    main()
