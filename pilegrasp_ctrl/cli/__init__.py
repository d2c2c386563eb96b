"""The command line `pilegrasp`: a thin layer over the library.

Results go to standard output, everything else to standard error. The exit status is 0 if the command did what it was
asked, 2 after an error and 130 after an interrupt. An attempt that grasps nothing is a result, not an error.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from contextlib import nullcontext
from typing import Any

from .interrupts import Interrupts

READER_LEFT = 141
"""Exit status if the reader of standard output has closed it: 128 + 13, as a shell shows for SIGPIPE."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit status: 0, 2 after an error, 130 after an interrupt.

    Without `arguments`, those of the process are used, and the process is expected to end afterwards.
    """
    # Python lets the main thread alone handle signals.
    in_main_thread = threading.current_thread() is threading.main_thread()
    guard = Interrupts(at_once_in_the_end=arguments is None) if in_main_thread else nullcontext()
    with guard as interrupts:
        from .program import run_program

        return run_program(arguments, interrupts)


def __getattr__(name: str) -> Any:
    if name != "app":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from .program import app

    return app
