"""One run of the command line, from its arguments to its exit status."""

from __future__ import annotations

import logging
import os
import sys
import traceback
from collections.abc import Sequence
from typing import TextIO, TypeGuard

from ..exceptions import ConfigurationError, PilegraspError, shortened
from . import (  # noqa: F401  (importing registers the verbs)
    READER_LEFT,
    bench,
    check,
    doctor,
    export,
    list_scenarios,
    paper,
    report,
    run,
    search,
    show,
    sweep,
    tune,
)
from .application import app, printable
from .interrupts import INTERRUPTED, Interrupts

__all__ = ["app", "run_program"]

COMPLETION = "_PILEGRASP_COMPLETE"
"""Variable of the environment by which a shell asks for completions."""

LOG = "PILEGRASP_LOG"
"""Variable of the environment with the level from which notes of the library are shown, such as `info`."""

LOGGER = "pilegrasp_ctrl"
"""Name of the library's logger."""


def run_program(arguments: Sequence[str] | None, interrupts: Interrupts | None) -> int:
    """Run the command line and return its exit status; see `main`."""
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    try:
        if interrupts is not None:
            interrupts.begin()
        if sys.stdout is None:
            raise PilegraspError("standard output is closed, so a result would go nowhere; redirect it to /dev/null")
        for stream in (sys.stdout, sys.stderr):
            _accept_every_name(stream)
        _show_notes(os.environ.get(LOG))
        status = app(args=arguments, prog_name="pilegrasp", standalone_mode=False)
        sys.stdout.flush()
        return int(status or 0)
    except KeyboardInterrupt:
        return INTERRUPTED
    except SystemExit as end:
        if COMPLETION in os.environ or not end.code:
            # The shell has asked what the tab key should offer, or completion was installed.
            return int(end.code or 0)
        _discard(sys.stdout)
        return READER_LEFT
    except BrokenPipeError:
        # The reader has closed the stream; rich turns that into SystemExit. Without `_discard` the interpreter reports
        # the error again when it closes the stream.
        _discard(sys.stdout)
        return READER_LEFT
    except Exception as error:
        if interrupts is not None and interrupts.received:
            # A library has turned the interrupt into an error of its own.
            return INTERRUPTED
        if "--debug" in arguments:
            traceback.print_exc()
        else:
            print(f"error: {printable(shortened(_sentence(error)))}", file=sys.stderr)
        if _is_of_a_print(error):
            _discard(sys.stdout)
        return 2


def _show_notes(level: str | None) -> None:
    """Print the notes of the library on standard error, from a level on.

    Raises:
        ConfigurationError: There is no such level.
    """
    if not level:
        return
    levels = ("debug", "info", "warning", "error")
    if level.lower() not in levels:
        raise ConfigurationError(f"{LOG}={level!r:.80} is not allowed: it must be {', '.join(levels)}")
    handler = logging.StreamHandler()
    handler.setFormatter(logging.Formatter("%(asctime)s %(name)s %(levelname)s: %(message)s", "%H:%M:%S"))
    logger = logging.getLogger(LOGGER)
    logger.handlers, logger.propagate = [handler], False
    logger.setLevel(level.upper())


def _accept_every_name(stream: TextIO) -> None:
    """Let a stream print names of files that its encoding does not have.

    Bytes of a name that are not UTF-8 are printed as they are.
    """
    if hasattr(stream, "reconfigure"):
        stream.reconfigure(errors="surrogateescape" if stream.encoding.lower() == "utf-8" else "backslashreplace")


def _discard(stream: TextIO) -> None:
    """Discard the rest in the buffer of a stream."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _is_of_a_print(error: Exception) -> TypeGuard[OSError]:
    """Return whether an error comes from printing, as on a full disk, rather than from a file."""
    if not isinstance(error, OSError) or error.filename is not None:
        return False
    *_, (frame, _) = traceback.walk_tb(error.__traceback__)
    return str(frame.f_globals.get("__name__")).startswith((__package__, "rich."))


def _sentence(error: Exception) -> str:
    """Return the text for an error of any type."""
    if isinstance(error, PilegraspError):
        return str(error)
    if hasattr(error, "format_message"):  # what typer raises for a wrong option or argument
        return f"{error.format_message().rstrip('.')}; see `{_command(error)} --help`"
    if _is_of_a_print(error):
        return f"standard output cannot be written: {error.strerror}"
    if isinstance(error, OSError) and error.strerror:
        return f"{'the system refuses' if error.filename is None else error.filename}: {error.strerror}"
    if isinstance(error, MemoryError):
        return "the memory is too small for this; ask for less at a time, or close other programs"
    return f"internal error ({type(error).__name__}: {error}); run again with --debug for the traceback"


def _command(error: Exception) -> str:
    """Return the command whose options are wrong, as it was called."""
    context = getattr(error, "ctx", None)
    return str(context.command_path) if context else "pilegrasp"
