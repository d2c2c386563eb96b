"""The program itself: what it says without a verb."""

from __future__ import annotations

from typing import Annotated

import typer

from ..exceptions import PilegraspError
from ..provenance import VERSION
from .options import DebugOption

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False, rich_markup_mode="markdown")


@app.callback(
    invoke_without_command=True,
    epilog="To begin: `pilegrasp run spheres_wall --html grasp.html`, then open grasp.html in a browser.",
)
def pilegrasp(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", metavar="", help="Print the version.")] = False,
    debug: DebugOption = False,
) -> None:
    """Simulate a robot that grasps from a pile without seeing it, and look at what happened."""
    if version:
        print(VERSION)
    elif context.invoked_subcommand is None:
        raise PilegraspError("no command is given; `pilegrasp --help` lists them")
