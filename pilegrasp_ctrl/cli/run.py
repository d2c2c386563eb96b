"""`pilegrasp run`."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import Progress, SpinnerColumn, TextColumn
from rich.table import Table

from ..output_file import check_output
from .application import app
from .options import DebugOption, JsonOption, make_console, print_json

if TYPE_CHECKING:
    from ..episode import EpisodeResult


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
    from ..config import load_scenario, parse_overrides

    chosen = load_scenario(scenario, parse_overrides(settings or []))
    for path, suffix in ((record, ".npz"), (html, ".html")):
        if path is not None:
            check_output(path, suffix)

    from ..episode import run

    with _progress(chosen.name) as progress:
        result = run(chosen, seed=seed, record=record is not None or html is not None, progress=progress)
    if result.recording is not None:
        if record is not None:
            result.recording.save(record)
        if html is not None:
            from ..viewer import write_html

            write_html(result.recording, html)
    if as_json:
        print_json(result.as_dict())
    else:
        _print_result(result, [path for path in (record, html) if path is not None])


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
    console = make_console()
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
