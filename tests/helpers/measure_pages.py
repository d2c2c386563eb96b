"""Size and time of the pages of synthetic attempts: `python tests/helpers/measure_pages.py` prints a table."""

from __future__ import annotations

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
from synthetic_recording import synthetic


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


def main() -> None:
    """Print size, processor time of the export, and time until the scene is drawn, for four recordings."""
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
