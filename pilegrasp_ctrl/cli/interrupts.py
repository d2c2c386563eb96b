"""Signals that end the command line: Ctrl-C, `kill` and a closed terminal clean up and give the same exit status."""

from __future__ import annotations

import os
import signal
import sys
import time
from types import FrameType
from typing import Any, Self

from ..interruption import ENDING

INTERRUPTED = 130
"""Exit status after an interrupt: 128 + 2, as a shell shows for SIGINT."""

REPEAT_AFTER = 5.0
"""Time after which a further signal interrupts again [s], chosen: cleaning up takes less."""

RETRY_AFTER = 0.02
"""Time after which an interrupt is raised again that a function without a caller has lost [s], chosen."""


class Interrupts:
    """Turns signals into `KeyboardInterrupt` while it is entered; it must be entered in the main thread.

    Before `begin` there is nothing to clean up, so a signal ends the process at once and no import is torn apart. After
    the first signal, others are ignored for `REPEAT_AFTER`, so that nothing tears the cleaning up apart.

    Attributes:
        received: Whether a signal has come.
    """

    def __init__(self, at_once_in_the_end: bool) -> None:
        """Set whether signals end the process at once after the exit, until the process ends by itself."""
        self.received = False
        self._at_once_in_the_end = at_once_in_the_end
        self._at_once = True
        self._last = -REPEAT_AFTER
        self._before: dict[signal.Signals, Any] = {}
        self._hook = sys.unraisablehook

    def __enter__(self) -> Self:
        for number in ENDING:
            if signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):
                self._before[number] = signal.signal(number, self._handle)
        self._before[signal.SIGALRM] = signal.signal(signal.SIGALRM, self._handle)
        sys.unraisablehook = self._retry
        return self

    def begin(self) -> None:
        """Let signals raise `KeyboardInterrupt` from now on."""
        self._at_once = False

    def __exit__(self, *_: object) -> None:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        sys.unraisablehook = self._hook
        # An interrupt that passes through an `exec` of text, as when a dataclass is made, marks the process:
        # `python -m` then ends it by SIGINT, whatever its exit status. The next `exec` takes the mark away.
        exec("pass")
        self._at_once = True
        if not self._at_once_in_the_end:
            for number, handler in self._before.items():
                signal.signal(number, handler)

    def _handle(self, number: int, frame: FrameType | None) -> None:
        self.received = True
        if self._at_once:
            os._exit(INTERRUPTED)
        now = time.monotonic()
        if now - self._last >= REPEAT_AFTER:
            self._last = now
            raise KeyboardInterrupt

    def _retry(self, lost: Any) -> None:
        """Raise an interrupt again that a destructor or a callback has lost; report every other error as usual."""
        if lost.exc_type is not KeyboardInterrupt:
            self._hook(lost)
            return
        self._last = -REPEAT_AFTER
        signal.setitimer(signal.ITIMER_REAL, RETRY_AFTER)
