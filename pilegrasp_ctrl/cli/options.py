"""What every verb shares: its options, where results go, and how progress is shown."""

from __future__ import annotations

import json
import sys
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.progress import Progress, ProgressColumn

# Without a metavar the help shows flags as `--json <bool>`, as if they took a value.
JsonOption = Annotated[bool, typer.Option("--json", metavar="", help="Print one JSON document and nothing else.")]
DebugOption = Annotated[bool, typer.Option("--debug", metavar="", help="Show the traceback of an error.")]

NARROWEST = 60
"""A terminal narrower than this wraps the lines itself; no column is cut [characters]."""


def make_console() -> Console:
    """Return a console that cuts nothing: a line is a line where a file or a program reads it."""
    console = Console()
    return Console(width=max(console.width, NARROWEST) if console.is_terminal else 1000)


def make_progress(*columns: ProgressColumn) -> Progress:
    """Return bars on standard error that go when they are done; where nobody watches they show nothing."""
    return Progress(*columns, console=Console(stderr=True), transient=True, disable=not sys.stderr.isatty())


def print_json(document: Any) -> None:
    """Print the one document that `--json` promises; a value that is not finite is a defect, not JSON."""
    print(json.dumps(document, indent=2, allow_nan=False))
