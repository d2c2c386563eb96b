"""`pilegrasp search`."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.markup import escape
from rich.table import Table

from ..plugins import use_plugins
from ..search import MAX_BUDGET
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
from .study_options import (
    JobsOption,
    SchedulerOption,
    TlsCaOption,
    TlsCertOption,
    TlsKeyOption,
    parse_seeds,
    parse_vary,
    read_scheduler,
    repeat_command,
    search_progress,
    worker_count,
)


class Aim(StrEnum):
    """Objectives of a search."""

    held = "held"
    single = "single"
    picks = "picks"
    robust = "robust"


@app.command(
    "search",
    epilog=with_examples(
        "Run it again with the same options, and it goes on where it was. A larger budget continues a search. "
        "An interrupt loses no finished attempt.",
        "pilegrasp search cylinders_wall --over strategy.alpha_deg=-60:60 --over strategy.grasp_force=8:40 --out found",
    ),
)
def search(
    scenario: ScenarioArgument,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for scenario, table, page and attempts.")],
    over: Annotated[
        list[str] | None,
        typer.Option(metavar="KEY=LOW:HIGH|A,B,C", help="Values that a key may take; may be repeated."),
    ] = None,
    objective: Annotated[
        Aim,
        typer.Option(
            metavar="held|single|picks|robust",
            help="What to make large: attempts that hold something, that hold exactly one object, picks an hour, or "
            "attempts that hold something in the worst world of --vary.",
        ),
    ] = Aim.held,
    vary: Annotated[
        list[str] | None,
        typer.Option(metavar="KEY=A,B,C", help="Worlds of the robust objective: every combination; may be repeated."),
    ] = None,
    budget: Annotated[
        int, typer.Option(min=1, max=MAX_BUDGET, metavar="N", help="Attempts of the race; the judgement is beside it.")
    ] = 1000,
    seeds: Annotated[
        str, typer.Option(metavar="FIRST:LAST", help="Seeds of the race, the last one left out.")
    ] = "0:1000",
    judge: Annotated[
        str, typer.Option(metavar="FIRST:LAST", help="Seeds on which winner and start are compared.")
    ] = "30000:30100",
    ablate: Annotated[
        bool,
        typer.Option(
            "--ablate", metavar="", help="Put the winner's keys back one by one, and report the smallest change."
        ),
    ] = False,
    jobs: JobsOption = None,
    scheduler: SchedulerOption = None,
    tls_ca: TlsCaOption = None,
    tls_cert: TlsCertOption = None,
    tls_key: TlsKeyOption = None,
    settings: SettingsOption = None,
    plugins: PluginsOption = None,
    as_json: JsonOption = False,
    debug: DebugOption = False,
) -> None:
    """Search for the strategy that holds most: candidates race, and the winner is judged on fresh seeds."""
    use_plugins(plugins or ())
    cluster = read_scheduler(scheduler, tls_ca, tls_cert, tls_key)
    workers = worker_count(jobs, cluster)
    numbers, fresh = parse_seeds(seeds), parse_seeds(judge)

    from ..config import parse_overrides
    from ..search.space import parse_over

    parameters, worlds, overrides = parse_over(over or []), parse_vary(vary or []), parse_overrides(settings or [])

    from ..search.results import write_results
    from ..search.run import plan_search, run_search

    planned = plan_search(
        scenario,
        parameters,
        out,
        overrides=overrides,
        objective=objective.value,
        vary=worlds,
        budget=budget,
        seeds=numbers,
        judging=fresh,
    )
    with search_progress(Path(scenario).stem, "attempts", out) as progress:
        result = run_search(
            planned, workers, cluster, lambda words, done, total: progress(words, done, total, ""), ablate
        )
    options: dict[str, Any] = {"--over": over, "--vary": vary, "--set": settings, "--plugins": plugins}
    options |= {"--objective": objective.value, "--budget": budget, "--seeds": seeds, "--judge": judge}
    command = repeat_command("search", scenario, options, out) + (" --ablate" if ablate else "")
    document = write_results(result, command)
    if as_json:
        print_json(document)
    else:
        _print_result(document)


def _print_result(document: Mapping[str, Any]) -> None:
    console = make_console()
    judged, timed = document["judgement"], document["objective"] == "picks"
    unit = " %" if timed else " points"
    console.print(
        f"{escape(document['scenario'])}, {document['objective']}: {len(document['candidates'])} candidates, "
        f"{document['attempts']} attempts; on {judged['n']} fresh seeds {judged['winner']:.3g}, the start "
        f"{judged['start']:.3g}, gain {100 * judged['low']:+.0f} to {100 * judged['high']:+.0f}{unit}: "
        f"{document['verdict']}",
        highlight=False,
        soft_wrap=True,
    )
    table = Table(box=None, pad_edge=False)
    for column in ("key", "start", "winner"):
        table.add_column(column)
    for key, value in document["start"].items():
        table.add_row(*(escape(str(cell)) for cell in (key, value, document["winner"]["set"].get(key, value))))
    console.print(table)
    if document["ablation"] is not None:
        kept = document["ablation"]["smallest"]
        words = ", ".join(f"{key} = {value}" for key, value in kept.items()) or "none at all"
        console.print(f"smallest change that is not worse: {escape(words)}", highlight=False, soft_wrap=True)
    if len(document["undecided"]):
        console.print(f"not eliminated: {len(document['undecided'])} other candidates; the page says more of them")
    for path in document["files"].values():
        console.print(f"wrote {escape(path)}", highlight=False, soft_wrap=True)
