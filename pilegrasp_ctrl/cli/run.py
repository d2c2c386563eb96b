"""`pilegrasp run`."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.markup import escape
from rich.progress import SpinnerColumn, TextColumn
from rich.table import Table

from ..exceptions import ExportError
from ..files import VIEWS, check_output
from ..plugins import use_plugins
from ..study import MAX_SEED
from .application import (
    DebugOption,
    JsonOption,
    PluginsOption,
    ScenarioArgument,
    SettingsOption,
    app,
    make_console,
    print_json,
    with_examples,
)
from .export import EmbedOption, drawing_progress
from .progress import make_progress

if TYPE_CHECKING:
    from ..config import Scenario
    from ..programs.result import EpisodeResult
    from ..viewer.live import LiveView


@app.command(
    "run",
    epilog=with_examples(
        "An attempt that grasps nothing is a result, not an error: the exit status is 0. "
        "An error about an unknown key lists the known ones.",
        "pilegrasp run spheres_wall --seed 0 --html grasp.html",
        "pilegrasp run spheres_wall --set pile.count=5 --set strategy.grasp_force=12",
        "pilegrasp run mine.toml --record grasp.npz --json",
    ),
)
def run_scenario(
    scenario: ScenarioArgument,
    seed: Annotated[
        int, typer.Option(min=0, max=MAX_SEED, metavar="S", help="Seed of the pile and of the sensor's noise.")
    ] = 0,
    settings: SettingsOption = None,
    record: Annotated[Path | None, typer.Option(metavar="F.npz", help="Write the recording to this file.")] = None,
    html: Annotated[
        Path | None, typer.Option(metavar="F.html", help="Write a page that shows the attempt in any browser, offline.")
    ] = None,
    export: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="F.html|F.png|F.mp4|...", help="Write what `pilegrasp export` makes of a recording; repeatable."
        ),
    ] = None,
    live: Annotated[
        bool,
        typer.Option("--live", metavar="", help="Show the attempt in a browser on this machine, in real time."),
    ] = False,
    plugins: PluginsOption = None,
    embed_recording: EmbedOption = False,
    as_json: JsonOption = False,
    debug: DebugOption = False,
) -> None:
    """Run one attempt: settle the pile, approach, push, grasp, lift."""
    from ..config import load_scenario, parse_overrides

    use_plugins(plugins or ())
    chosen = load_scenario(scenario, parse_overrides(settings or []))
    shown = [path for path in (html, *(export or [])) if path is not None]
    for path in (record, html):
        if path is not None:
            check_output(path, ".npz" if path is record else ".html")
    for path in export or []:
        check_output(path, *VIEWS)
    if embed_recording and not any(path.suffix == ".html" for path in shown):
        raise ExportError("--embed-recording puts the recording into a page; name one by --html F.html")
    if shown:
        from ..viewer import require_programs

        for path in shown:
            require_programs(path)

    from ..episode import run

    with ExitStack() as stack:
        watch = stack.enter_context(_live_view(chosen, seed)) if live else None
        with _progress(chosen.name) as progress:
            hooks: dict[str, Any] = {"on_frame": watch.show, "on_sample": watch.sample} if watch else {}
            result = run(chosen, seed=seed, record=bool(record or shown), progress=progress, **hooks)
        if watch:
            watch.finish(result.as_dict())
    if result.recording is not None:
        if record is not None:
            from ..analysis.motion import annotate

            annotate(result.recording).save(record)
        if shown:
            from ..viewer import write

            for path in shown:
                with drawing_progress(path) as drawn:
                    is_page = path.suffix == ".html"
                    write(
                        result.recording,
                        path,
                        progress=drawn,
                        embed_recording=embed_recording and is_page,
                        sources=[os.path.relpath(record, path.parent)] if record and not embed_recording else [],
                    )
    if as_json:
        print_json(result.as_dict())
    else:
        _print_result(result, [path for path in (record, *shown) if path is not None])


@contextmanager
def _live_view(scenario: Scenario, seed: int) -> Iterator[LiveView]:
    """Serve the page of the running attempt, and print its address."""
    from ..viewer.live import FIRST_PAGE_TIMEOUT, LiveView

    with LiveView(f"{scenario.name}, seed {seed}", config=scenario.model_dump(mode="json")) as view:
        print(
            f"watch at {view.url} (the attempt begins when the page is open, or after {FIRST_PAGE_TIMEOUT:.0f} s)",
            file=sys.stderr,
            flush=True,
        )
        yield view


@contextmanager
def _progress(name: str) -> Iterator[Callable[[float, str], None]]:
    """Show the simulated time and the primitive while an attempt runs."""
    with make_progress(SpinnerColumn(), TextColumn("{task.description}")) as bar:
        line = bar.add_task(escape(f"{name}: preparing"))
        yield lambda time, primitive: bar.update(line, description=escape(f"{name}: {time:.1f} s, {primitive}"))


def _print_result(result: EpisodeResult, written: list[Path]) -> None:
    facts = result.as_dict()
    console = make_console()
    verdict = "[green]success[/]" if facts["success"] else f"[red]no success[/]: {escape(facts['reason'])}"
    held = f"; objects held: {facts['grasped']}" if facts["grasped"] else ""
    console.print(f"{escape(facts['scenario'])}, seed {facts['seed']}: {verdict}{held}", soft_wrap=True)
    for note in facts.get("notes", []):
        console.print(f"note: {escape(note)}", soft_wrap=True)
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
    times = (
        "control tick {median_us:.0f} us (p99 {p99_us:.0f} us)".format(**tick) if tick["ticks"] else "no control tick"
    )
    console.print(
        f"{facts['sim_time']:.1f} s simulated at {facts['realtime_factor']:.1f}x real time, {times}",
        highlight=False,
    )
    for path in written:
        console.print(f"wrote {escape(str(path))}", highlight=False, soft_wrap=True)
