"""Progress on standard error: bars on a terminal, and a line now and then elsewhere."""

from __future__ import annotations

import sys
import time
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, SpinnerColumn, TaskID

LINE_PERIOD = 30.0
"""Time between two lines of progress outside a terminal, and before the first one [s]; chosen: a log of an hour has 120
lines, and a short command has none."""

DRAWN = (BarColumn, SpinnerColumn)
"""Columns that are pictures; a line leaves them out."""


class ProgressLines(Progress):
    """Progress that prints a line to standard error every `LINE_PERIOD`, for logs and programs that read them."""

    def __init__(self, *columns: ProgressColumn) -> None:
        """Take the columns of the bar; a line holds their texts."""
        super().__init__(*columns, console=Console(stderr=True), disable=True)
        self._due = time.monotonic() + LINE_PERIOD

    def update(self, task_id: TaskID, **changes: Any) -> None:
        """Note progress, and print a line if one is due."""
        super().update(task_id, **changes)
        if time.monotonic() >= self._due:
            self._due = time.monotonic() + LINE_PERIOD
            print(self.line(task_id), file=sys.stderr, flush=True)

    def line(self, task_id: TaskID) -> str:
        """Return the present state of a task as a line of text."""
        task = next(task for task in self.tasks if task.id == task_id)
        told = [
            column for column in self.columns if isinstance(column, ProgressColumn) and not isinstance(column, DRAWN)
        ]
        return " ".join(text for column in told if (text := str(column.render(task)).strip()))


def make_progress(*columns: ProgressColumn) -> Progress:
    """Return progress bars on standard error, which vanish at the end; outside a terminal, lines now and then."""
    if not sys.stderr.isatty():
        return ProgressLines(*columns)
    return Progress(*columns, console=Console(stderr=True), transient=True)
