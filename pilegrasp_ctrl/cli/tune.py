"""`pilegrasp tune`."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.markup import escape
from rich.table import Table

from ..exceptions import ConfigurationError
from ..plugins import use_plugins
from ..study import MAX_JOBS
from ..tuning import MAX_TRIALS
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
from .study_options import parse_seeds, repeat_command, search_progress

MAX_SEEDS = 1000
"""Largest number of attempts in a trial (chosen)."""


class Controller(StrEnum):
    """Controllers whose gains can be tuned."""

    operational_space = "operational_space"
    impedance = "impedance"


@app.command(
    "tune",
    epilog=with_examples(
        "Run it again with the same options, and it runs only the missing trials. An interrupt loses no trial.",
        "pilegrasp tune free_space_line --controller operational_space --jobs 2 --out tuned",
        "pilegrasp tune push_wall --controller impedance --start mine.toml --trials 100 --out pushed",
    ),
)
def tune(
    scenario: ScenarioArgument,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for gains, trials and page.")],
    controller: Annotated[
        Controller | None,
        typer.Option(
            metavar="operational_space|impedance",
            help="Controller to tune; by default that of the scenario, or else of the hand.",
        ),
    ] = None,
    trials: Annotated[
        int, typer.Option(min=1, max=MAX_TRIALS, metavar="N", help="Number of gains to try, including the start.")
    ] = 60,
    seeds: Annotated[
        str, typer.Option(metavar="FIRST:LAST", help="Seeds that each trial runs, the last one left out.")
    ] = "0:1",
    jobs: Annotated[
        int, typer.Option(min=1, max=MAX_JOBS, metavar="N", help="Processes; more than 4 do not help.")
    ] = 1,
    start: Annotated[
        Path | None, typer.Option(metavar="GAINS.toml", help="Gains to begin with; by default those that ship.")
    ] = None,
    late: Annotated[
        int,
        typer.Option(min=0, metavar="N", help="Demand the margin with torques that are N control periods late."),
    ] = 0,
    settings: SettingsOption = None,
    plugins: PluginsOption = None,
    as_json: JsonOption = False,
    debug: DebugOption = False,
) -> None:
    """Search for controller gains: small tracking error, calm torques, and a margin before the loop rings."""
    from ..config import load_scenario, parse_overrides

    use_plugins(plugins or ())
    overrides = parse_overrides(settings or [])
    if controller is not None:
        overrides["controller.kind"] = controller.value
    chosen = load_scenario(scenario, overrides)
    numbers = tuple(parse_seeds(seeds))
    if len(numbers) > MAX_SEEDS:
        raise ConfigurationError(
            f"--seeds {seeds!r} asks for {len(numbers)} attempts in each trial; {MAX_SEEDS} are enough"
        )

    from ..tuning.search import check_seeds, plan_search, run_search

    check_seeds(numbers)
    search = plan_search(chosen, out, start=start, seeds=numbers, late=late)

    from ..tuning.analysis import analyse_search
    from ..tuning.results import write_results

    with search_progress(chosen.name, "trials", out) as show:

        def progress(part: str, done: int, total: int, tracking: float | None) -> None:
            show(part, done, total, "" if tracking is None else f"best {tracking:.3g} mm")

        store = run_search(search, trials, jobs, progress)
        analysis = analyse_search(search, store, jobs, progress)
    options: dict[str, Any] = {
        "--controller": controller,
        "--trials": trials,
        "--seeds": seeds,
        "--jobs": jobs,
        "--start": start,
    }
    options |= {"--late": late or None, "--set": settings, "--plugins": plugins}
    command = repeat_command("tune", scenario, options, out)
    document = write_results(analysis, command)
    if as_json:
        print_json(document)
    else:
        _print_result(document)


def _print_result(document: Mapping[str, Any]) -> None:
    console = make_console()
    trials = document["trials"]
    console.print(
        f"{escape(document['scenario'])}, {document['controller']}: {trials['finished']} trials, "
        f"{trials['failed']} not completed, {trials['with_margin']} with margin",
        highlight=False,
        soft_wrap=True,
    )
    table = Table(box=None, pad_edge=False)
    for column in ("", "start", "best"):
        table.add_column(column, justify="right" if column else "left")
    start, best = document["start"], document["best"]
    for name, unit in document["objectives"].items():
        cells = [part["measured"] for part in (start, best)]
        table.add_row(escape(f"{name} [{unit}]"), *("-" if cell is None else f"{cell[name]:.3g}" for cell in cells))
    table.add_row("stability margin", *(_margin(part["margin"]) for part in (start, best)))
    console.print(table)
    console.print(f"Best: {escape(document['rule'])}.", soft_wrap=True, highlight=False)
    for path in document["files"].values():
        console.print(f"wrote {escape(path)}", highlight=False, soft_wrap=True)


def _margin(margin: Mapping[str, Any]) -> str:
    return f"{'>' if margin['at_least'] else ''}{margin['factor']:.2g}"
