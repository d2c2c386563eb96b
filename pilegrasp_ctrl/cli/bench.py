"""`pilegrasp bench`."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from ..files import check_output, write_output
from .application import DebugOption, JsonOption, app, make_console, print_json, with_examples
from .progress import make_progress

if TYPE_CHECKING:
    from ..validation.bench.judgement import Change
    from ..validation.bench.result import BenchResult, Row


@app.command(
    "bench",
    epilog=with_examples(
        "Ratios within one run can be trusted; microseconds depend on the machine and its load.",
        "pilegrasp bench --quick",
        "pilegrasp bench --save before.json",
        "pilegrasp bench --compare before.json",
    ),
)
def bench(
    quick: Annotated[
        bool, typer.Option("--quick", metavar="", help="Few samples: a quick look, not a result.")
    ] = False,
    save: Annotated[Path | None, typer.Option(metavar="F.json", help="Write the result to this file.")] = None,
    compare: Annotated[
        Path | None, typer.Option(metavar="F.json", help="Show what changed since this saved result.")
    ] = None,
    as_json: JsonOption = False,
    debug: DebugOption = False,
) -> None:
    """Measure the control tick, its peers, the closed loop and imports, as ratios within one run."""
    if save is not None:
        check_output(save, ".json")

    from ..validation.bench.benchmark import FULL, QUICK, run_benchmark
    from ..validation.bench.judgement import compare as compare_results
    from ..validation.bench.result import load_result

    old = None if compare is None else load_result(compare)
    with _progress() as progress:
        result = run_benchmark(QUICK if quick else FULL, progress)
    changes = None if old is None else compare_results(old, result)
    if save is not None:
        write_output(save, f"{result.model_dump_json(indent=1)}\n".encode(), "result")
    if as_json:
        document = result.model_dump(mode="json")
        if changes is not None:
            document["changes"] = [change.as_dict() for change in changes]
        print_json(document)
        return
    console = make_console()
    _print_result(console, result)
    if changes is not None:
        _print_changes(console, changes, str(compare))
    if save is not None:
        console.print(f"wrote {escape(str(save))}", highlight=False, soft_wrap=True)


@contextmanager
def _progress() -> Iterator[Callable[[float, str], None]]:
    """Show the finished share on standard error."""
    columns = (
        BarColumn(),
        TextColumn("{task.percentage:3.0f} %"),
        TimeElapsedColumn(),
        TextColumn("{task.description}"),
    )
    # This thread alone draws the bar; another thread would disturb the measurement.
    shown = Progress(*columns, console=Console(stderr=True), transient=True, auto_refresh=False)
    with shown if sys.stderr.isatty() else make_progress(*columns) as bar:
        line = bar.add_task("", total=1.0)
        yield lambda fraction, what: bar.update(line, completed=fraction, description=escape(what), refresh=True)


def _print_result(console: Console, result: BenchResult) -> None:
    settings = result.settings
    packages = ", ".join(f"{name} {number}" for name, number in result.versions.items())
    console.print(
        f"{settings.processor}, {settings.processors} processors; {packages}", highlight=False, soft_wrap=True
    )
    if settings.threads != "1":
        console.print(
            "[yellow]OMP_NUM_THREADS is not 1: threads of the linear algebra disturb the ticks", soft_wrap=True
        )
    if settings.load > settings.processors:
        console.print("[yellow]other programs are running: the tails grow most", soft_wrap=True)
    _print_rows(console, "tick (ratio: to the yardstick)", _of(result, "tick"), "us")
    _print_rows(console, "peer (ratio: to the operational-space tick)", _of(result, "peer"), "us")
    _print_rows(console, "part of the operational-space tick (ratio: to the yardstick)", _of(result, "stage"), "us")
    _print_rows(console, "fresh interpreter (ratio: to import numpy)", _of(result, "import"), "ms")
    _print_memory(console, result)
    _print_loop(console, result)
    table = _table("target", "measured", "", "target ", "verdict")
    for target in result.targets:
        verdict = {None: "[yellow]not measured", True: "[green]met", False: "[red]not met"}[target.met]
        value = "" if target.value is None else f"{target.value:.2f}"
        table.add_row(escape(target.name), value, target.relation, f"{target.bound:g}", verdict)
    console.print(table)


def _of(result: BenchResult, kind: str) -> list[Row]:
    return [row for row in result.rows if row.table == kind]


def _table(first: str, *columns: str) -> Table:
    table = Table(box=None, pad_edge=False)
    table.add_column(escape(first))
    for column in columns:
        table.add_column(escape(column), justify="right")
    return table


def _print_rows(console: Console, title: str, rows: Sequence[Row], unit: str) -> None:
    if not rows:
        return
    table = _table(title, f"median [{unit}]", "p99", "max", "tail", "ratio", "±")
    table.add_column("")
    scale = {"us": 1.0, "ms": 1e-3}[unit]
    for row in rows:
        times = ["" if value is None else f"{scale * value:.1f}" for value in (row.median_us, row.p99_us, row.worst_us)]
        tail, ratio = ("" if value is None else f"{value:.2f}" for value in (row.tail, row.ratio))
        spread = "" if row.spread is None else f"{100.0 * row.spread:.0f} %"
        table.add_row(escape(row.key), *times, tail, ratio, spread, escape(row.note))
    console.print(table)
    console.print()


def _print_memory(console: Console, result: BenchResult) -> None:
    table = _table("memory of a tick", "peak [B]", "kept by the answer [B]", "growth [B]", "in ticks")
    for row in result.memory:
        numbers = (f"{row.peak_bytes:.0f}", f"{row.kept_bytes:.0f}", str(row.growth_bytes), str(row.ticks))
        table.add_row(escape(row.key), *numbers)
    console.print(table)
    console.print()


def _print_loop(console: Console, result: BenchResult) -> None:
    settings = result.settings
    title = f"closed loop of {settings.scenario}, per control period"
    table = _table(title, "loop [us]", "bare", "control", "glue", "loop / bare", "10 to 90 %", "x real time")
    for row in result.loop:
        times = [f"{value:.0f}" for value in (row.period_us, row.bare_us, row.control_us, row.glue_us)]
        spread = f"{row.ratio_p10:.2f} to {row.ratio_p90:.2f}"
        table.add_row(row.phase, *times, f"{row.ratio:.2f}", spread, f"{row.realtime_factor:.1f}")
    console.print(table)
    if not result.replay_exact:
        console.print("[red]a replay left the loop's trajectory: its times belong to another motion", soft_wrap=True)
    console.print()


def _print_changes(console: Console, changes: Sequence[Change], path: str) -> None:
    console.print()
    table = _table(f"since {path}", "old ratio", "new ratio", "old / new", "noise ±")
    table.add_column("")
    for change in changes:
        numbers = (f"{change.old:.2f}", f"{change.new:.2f}", f"{change.factor:.2f}", f"{100.0 * change.noise:.0f} %")
        table.add_row(escape(change.key), *numbers, change.verdict)
    console.print(table)
    if not changes:
        console.print("The two results have no line in common.")
