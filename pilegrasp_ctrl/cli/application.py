"""The parts that every verb shares: the program, common options, examples, and the console for results."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from ..exceptions import PilegraspError
from ..provenance import VERSION
from .completion import complete_scenario, complete_setting

# Without a metavar the help shows flags as `--json <bool>`, as if they took a value.
JsonOption = Annotated[bool, typer.Option("--json", metavar="", help="Print one JSON document and nothing else.")]
DebugOption = Annotated[bool, typer.Option("--debug", metavar="", help="Show the traceback of an error.")]
ScenarioArgument = Annotated[
    str,
    typer.Argument(
        metavar="NAME|FILE.toml",
        help="A scenario that `pilegrasp list` shows, or your own file.",
        autocompletion=complete_scenario,
    ),
]
SettingsOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Change a key, as in pile.count=5; may be repeated.",
        autocompletion=complete_setting,
    ),
]
PluginsOption = Annotated[
    list[Path] | None,
    typer.Option(
        "--plugins", metavar="DIR", help="Folder of your own functions, named as module:function; may be repeated."
    ),
]

MIN_WIDTH = 60
"""Narrowest table [characters] (chosen). A narrower terminal wraps the lines itself; no column is cut."""
FILE_WIDTH = 1000
"""Width of a table that goes to a file or a program [characters] (chosen): no line is wrapped."""

app = typer.Typer(pretty_exceptions_enable=False, rich_markup_mode="markdown")


def with_examples(text: str, *commands: str) -> str:
    """Return the end of a help text: a remark, and commands to copy."""
    return "\n\n".join([*([text] if text else []), "Examples:", *(f"- `{command}`" for command in commands)])


@app.callback(
    invoke_without_command=True,
    epilog=with_examples(
        "`PILEGRASP_LOG=info` in the environment shows what the library notes while it works.",
        "pilegrasp run spheres_wall --html grasp.html",
        "pilegrasp list",
        "pilegrasp doctor",
    ),
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


def make_console() -> Console:
    """Return a console that cuts no column, and wraps no line for a file or a program that reads it."""
    console = Console()
    return Console(width=max(console.width, MIN_WIDTH) if console.is_terminal else FILE_WIDTH)


def printable(text: str) -> str:
    """Return a text on one line without control characters, which could change the terminal that shows them."""
    line = " ".join(text.split())
    return "".join(letter if letter.isprintable() else letter.encode("unicode_escape").decode() for letter in line)


def print_json(document: Any) -> None:
    """Print the one document that `--json` promises; a value that is not finite raises an error."""
    print(json.dumps(document, indent=2, allow_nan=False))
