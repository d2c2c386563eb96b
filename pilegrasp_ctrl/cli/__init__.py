"""The command line `pilegrasp`: a thin layer over the library.

Results go to standard output, everything else to standard error. The exit status is 0 if the command did what it was
asked, 2 after an error and 130 after an interrupt. An attempt that grasps nothing is a result, not an error.
"""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Sequence
from typing import TextIO, TypeGuard

from ..exceptions import PilegraspError
from . import (  # noqa: F401  (importing registers the verbs)
    bench,
    doctor,
    export,
    list_scenarios,
    paper,
    report,
    run,
    sweep,
    tune,
)
from .application import app

__all__ = ["app", "main"]

READER_LEFT = 141
"""Exit status if the reader of standard output has closed it: 128 + 13, as a shell shows for SIGPIPE."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit status: 0, 2 after an error, 130 after an interrupt."""
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    try:
        if sys.stdout is None:
            raise PilegraspError("standard output is closed, so a result would go nowhere; redirect it to /dev/null")
        status = app(args=arguments, prog_name="pilegrasp", standalone_mode=False)
        sys.stdout.flush()
        return int(status or 0)
    except KeyboardInterrupt:
        return 130
    except (BrokenPipeError, SystemExit):
        # The reader has closed the stream; rich turns that into SystemExit. Without `_discard` the interpreter reports
        # the error again when it closes the stream.
        _discard(sys.stdout)
        return READER_LEFT
    except Exception as error:
        if "--debug" in arguments:
            traceback.print_exc()
        else:
            print(f"error: {_sentence(error)}", file=sys.stderr)
        if _is_of_a_stream(error):
            _discard(sys.stdout)
        return 2


def _discard(stream: TextIO) -> None:
    """Discard the rest in the buffer of a stream."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _is_of_a_stream(error: Exception) -> TypeGuard[OSError]:
    """Return whether an error belongs to a standard stream, as for a full disk; an error of a file has a file name."""
    return isinstance(error, OSError) and error.errno is not None and error.filename is None


def _sentence(error: Exception) -> str:
    if isinstance(error, PilegraspError):
        text = str(error)
    elif hasattr(error, "format_message"):  # what typer raises for a wrong option or argument
        text = f"{error.format_message().rstrip('.')}; see `{_command(error)} --help`"
    elif _is_of_a_stream(error):
        text = f"standard output cannot be written: {error.strerror}"
    else:
        text = f"internal error ({type(error).__name__}: {error}); run again with --debug for the traceback"
    return " ".join(text.split())


def _command(error: Exception) -> str:
    """Return the command whose options are wrong, as it was called."""
    context = getattr(error, "ctx", None)
    return str(context.command_path) if context else "pilegrasp"
