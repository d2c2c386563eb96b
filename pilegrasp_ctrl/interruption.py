"""Keep signals waiting for a moment in which they would leave a process or folder without an owner."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""Signals that interrupt the program, unless its parent told it to ignore them."""


@contextmanager
def signals_wait() -> Iterator[None]:
    """Let signals that would interrupt the block wait for its end. Other threads get no signals, so they do nothing.

    A child that is started in the block gets signals as usual, unlike with a mask, which it would inherit.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    waiting: list[int] = []

    def note(number: int, frame: FrameType | None) -> None:
        waiting.append(number)

    # The alarm raises an interrupt again that a destructor has lost.
    numbers = (*ENDING, signal.SIGALRM)
    handlers = {number: handler for number in numbers if callable(handler := signal.getsignal(number))}
    try:
        for number in handlers:
            signal.signal(number, note)
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        if waiting:
            signal.raise_signal(waiting[0])
