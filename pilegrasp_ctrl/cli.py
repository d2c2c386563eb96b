"""The command line `pilegrasp`: a thin layer over the library.

Results go to standard output, everything else to standard error. The exit status is 0 where the command did what it was
asked, 2 after an error and 130 after an interrupt; an attempt that runs and grasps nothing was carried out as asked.
"""

from __future__ import annotations

import json
import os
import sys
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TextIO, TypeGuard

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import Progress, SpinnerColumn, TextColumn
from rich.table import Table

from . import __version__
from .exceptions import ConfigurationError, PilegraspError
from .output_file import check_output

if TYPE_CHECKING:
    from .episode import EpisodeResult

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False, rich_markup_mode="markdown")

# Without a metavar the help shows flags as `--json <bool>`, as if they took a value.
JsonOption = Annotated[bool, typer.Option("--json", metavar="", help="Print one JSON document and nothing else.")]
DebugOption = Annotated[bool, typer.Option("--debug", metavar="", help="Show the traceback of an error.")]

READER_LEFT = 141
"""The status that a shell shows for a program that SIGPIPE ended."""

NARROWEST = 60
"""A terminal narrower than this wraps the lines itself; no column is cut [characters]."""


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
        # The reader has left, which rich turns into SystemExit. Without this the interpreter complains once more when
        # it closes the stream.
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
    """Send what is still in the stream's buffer nowhere."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


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
        print(__version__)
    elif context.invoked_subcommand is None:
        raise PilegraspError("no command is given; `pilegrasp --help` lists them")


@app.command("list")
def list_scenarios(
    tag: Annotated[str | None, typer.Option(metavar="TAG", help="Only the scenarios that carry this tag.")] = None,
    as_json: JsonOption = False,
    debug: DebugOption = False,
) -> None:
    """List the scenarios that `run` knows by name."""
    from .config import load_scenario
    from .scenarios import names

    scenarios = [load_scenario(name) for name in names()]
    tags = sorted({known for scenario in scenarios for known in scenario.tags})
    if tag is not None and tag not in tags:
        raise ConfigurationError(f"no scenario carries the tag {tag!r}; the tags are {', '.join(tags)}")
    rows = [scenario for scenario in scenarios if tag is None or tag in scenario.tags]
    if as_json:
        _print_json([{"name": row.name, "tags": list(row.tags), "summary": row.summary} for row in rows])
        return
    table = Table(box=None, pad_edge=False)
    for column in ("scenario", "tags", "summary"):
        table.add_column(column)
    for row in rows:
        table.add_row(escape(row.name), escape(" ".join(row.tags)), escape(row.summary))
    _console().print(table)


@app.command(
    "run",
    epilog="An attempt that grasps nothing is a result, not an error: the exit status is 0. "
    "A key that does not exist is answered with those that do.",
)
def run_scenario(
    scenario: Annotated[
        str,
        typer.Argument(metavar="NAME|FILE.toml", help="A scenario that `pilegrasp list` shows, or a file of your own."),
    ],
    seed: Annotated[int, typer.Option(min=0, metavar="S", help="Seed of the pile and of the sensor's noise.")] = 0,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Change a key, as in pile.count=5; may be repeated."),
    ] = None,
    record: Annotated[Path | None, typer.Option(metavar="F.npz", help="Write the recording to this file.")] = None,
    html: Annotated[
        Path | None, typer.Option(metavar="F.html", help="Write a page that shows the attempt in any browser, offline.")
    ] = None,
    as_json: JsonOption = False,
    debug: DebugOption = False,
) -> None:
    """Carry out one attempt: settle the pile, approach, push, grasp, lift."""
    from .config import load_scenario, parse_overrides

    chosen = load_scenario(scenario, parse_overrides(settings or []))
    for path, suffix in ((record, ".npz"), (html, ".html")):
        if path is not None:
            check_output(path, suffix)

    from .episode import run

    with _progress(chosen.name) as progress:
        result = run(chosen, seed=seed, record=record is not None or html is not None, progress=progress)
    if result.recording is not None:
        if record is not None:
            result.recording.save(record)
        if html is not None:
            from .viewer import write_html

            write_html(result.recording, html)
    if as_json:
        _print_json(result.as_dict())
    else:
        _print_result(result, [path for path in (record, html) if path is not None])


@app.command("export")
def export_recording(
    recording: Annotated[Path, typer.Argument(metavar="F.npz", help="What `pilegrasp run --record` wrote.")],
    html: Annotated[Path, typer.Argument(metavar="F.html", help="The page to write.")],
    as_json: JsonOption = False,
    debug: DebugOption = False,
) -> None:
    """Turn a recording into a page that shows the attempt in any browser, offline."""
    check_output(html, ".html")

    from .recording import Recording
    from .viewer import write_html

    write_html(Recording.load(recording), html)
    if as_json:
        _print_json({"recording": str(recording), "html": str(html), "bytes": html.stat().st_size})
    else:
        print(html)


@app.command("doctor")
def doctor(as_json: JsonOption = False, debug: DebugOption = False) -> None:
    """Check this installation: packages, solvers, engines, browser, and one short run."""
    from .doctor import examine

    checks = examine()
    failed = [check.name for check in checks if check.required and not check.ok]
    if as_json:
        _print_json({"ok": not failed, "checks": [check.as_dict() for check in checks]})
    else:
        table = Table(box=None, pad_edge=False)
        for column in ("check", "", "detail"):
            table.add_column(column)
        for check in checks:
            verdict = "[green]ok" if check.ok else "[red]failed" if check.required else "[yellow]absent"
            table.add_row(escape(check.name), verdict, escape(check.detail))
        _console().print(table)
        if not failed:
            print("All that is needed works.")
    if failed:
        raise PilegraspError(f"these checks failed: {', '.join(failed)}")


def _is_of_a_stream(error: Exception) -> TypeGuard[OSError]:
    """Tell a full disk behind standard output from the error of a file, which has a name."""
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
    """Return the command whose options were misused, as it was called."""
    context = getattr(error, "ctx", None)
    return str(context.command_path) if context else "pilegrasp"


def _console() -> Console:
    """Return a console that cuts nothing: a line is a line where a file or a program reads it."""
    console = Console()
    return Console(width=max(console.width, NARROWEST) if console.is_terminal else 1000)


def _print_json(document: Any) -> None:
    print(json.dumps(document, indent=2, allow_nan=False))


@contextmanager
def _progress(name: str) -> Iterator[Callable[[float, str], None] | None]:
    """Show the simulated time and the primitive while an attempt runs; nothing where nobody watches."""
    if not sys.stderr.isatty():
        yield None
        return
    with Progress(
        SpinnerColumn(), TextColumn("{task.description}"), console=Console(stderr=True), transient=True
    ) as bar:
        task = bar.add_task(escape(f"{name}: preparing"))
        yield lambda time, primitive: bar.update(task, description=escape(f"{name}: {time:.1f} s, {primitive}"))


def _print_result(result: EpisodeResult, written: list[Path]) -> None:
    facts = result.as_dict()
    console = _console()
    verdict = "[green]success[/]" if facts["success"] else f"[red]no success[/]: {escape(facts['reason'])}"
    held = f"; objects held: {facts['grasped']}" if facts["grasped"] else ""
    console.print(f"{escape(facts['scenario'])}, seed {facts['seed']}: {verdict}{held}", soft_wrap=True)
    table = Table(box=None, pad_edge=False)
    table.add_column("primitive")
    table.add_column("ended by")
    for column in ("from [s]", "to [s]", "travel [m]", "peak force [N]"):
        table.add_column(escape(column), justify="right")
    for outcome in facts["outcomes"]:
        table.add_row(
            escape(outcome["name"]),
            escape(outcome["trigger"]) if outcome["status"] == "ended" else f"[red]{escape(outcome['trigger'])}[/]",
            *(f"{outcome[key]:.2f}" for key in ("start", "end")),
            f"{outcome['travel']:.3f}",
            f"{outcome['peak_force']:.1f}",
        )
    console.print(table)
    tick = facts["controller"]
    console.print(
        f"{facts['sim_time']:.1f} s simulated at {facts['realtime_factor']:.1f}x real time, "
        f"control tick {tick['median_us']:.0f} us (p99 {tick['p99_us']:.0f} us)",
        highlight=False,
    )
    for path in written:
        console.print(f"wrote {escape(str(path))}", highlight=False, soft_wrap=True)
