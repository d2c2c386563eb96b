"""The signals of a recording as a table: a line for each sample, a column for each value."""

from __future__ import annotations

import csv
import io
import os
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from pilegrasp_ctrl.exceptions import ExportError
from pilegrasp_ctrl.files import write_output
from pilegrasp_ctrl.recording import Recording


def signal_table(recording: Recording) -> dict[str, NDArray[Any]]:
    """Return the columns of the table, each (S,): "time" [s], then the signals.

    A signal of several values has a column for each, such as "q[0]". The units are in `recording.meta["signal_units"]`.
    """
    columns: dict[str, NDArray[Any]] = {"time": recording.signal_time}
    for name, values in recording.signals.items():
        if values.ndim == 1:
            columns[name] = values
        else:
            columns |= {f"{name}[{index}]": values[:, index] for index in range(values.shape[1])}
    return columns


def write_csv(recording: Recording, path: str | os.PathLike[str]) -> None:
    """Write the signals as a CSV file, all of it or nothing; numbers keep all their digits.

    Raises:
        ExportError: The recording has no signals, or the path cannot be written.
    """
    columns = signal_table(recording)
    if len(columns) == 1:
        raise ExportError(f"{path}: the recording has no signals, so there is no table")
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*(map(str, column) for column in columns.values()), strict=True))
    write_output(Path(path), text.getvalue().encode(), "table")
