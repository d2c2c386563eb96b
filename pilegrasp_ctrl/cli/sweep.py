"""`pilegrasp sweep`."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping, Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.markup import escape
from rich.table import Table

from ..plugins import use_plugins
from .application import (
    DebugOption,
    JsonOption,
    PluginsOption,
    ScenarioArgument,
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
    saying_what_is_kept,
    study_progress,
    worker_count,
)

if TYPE_CHECKING:
    from ..study.attempt import AttemptRow
    from ..study.summary import SummaryRow

MAX_SHOWN_ERRORS = 3
"""How many different sentences of attempts that raised are shown (chosen); the store has all."""


class Recorded(StrEnum):
    """Which attempts leave a recording."""

    none = "none"
    failures = "failures"
    first = "first"
    all = "all"


@app.command(
    "sweep",
    epilog=with_examples(
        "Run it again with the same options, and it runs only the missing attempts; more seeds or values are added. "
        "An interrupt loses no finished attempt. `pilegrasp export DIR table.csv` writes them as a table.",
        "pilegrasp sweep spheres_wall --vary pile.count=5,18 --vary hand=rbo_hand2,shovel --seeds 0:50 --out counts",
        "pilegrasp sweep mine.toml --seeds 0:50 --record failures --out counts",
    ),
)
def sweep(
    scenario: ScenarioArgument,
    seeds: Annotated[str, typer.Option(metavar="FIRST:LAST", help="Seeds of each combination, the last one left out.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder of the study; made if it is missing.")],
    vary: Annotated[
        list[str] | None,
        typer.Option(metavar="KEY=A,B,C", help="Values of a key; may be repeated, then every combination runs."),
    ] = None,
    jobs: JobsOption = None,
    scheduler: SchedulerOption = None,
    tls_ca: TlsCaOption = None,
    tls_cert: TlsCertOption = None,
    tls_key: TlsKeyOption = None,
    record: Annotated[
        Recorded,
        typer.Option(
            metavar="none|failures|first|all", help="Which attempts leave a recording; first: one for each combination."
        ),
    ] = Recorded.none,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Change a key for all of them; may be repeated."),
    ] = None,
    measure: Annotated[
        str | None,
        typer.Option(
            metavar="MODULE:FUNCTION", help="Function of a recording that returns a dict of numbers for each attempt."
        ),
    ] = None,
    plugins: PluginsOption = None,
    as_json: JsonOption = False,
    debug: DebugOption = False,
) -> None:
    """Run every combination of the varied keys with every seed, and count the successes."""
    use_plugins(plugins or ())
    cluster = read_scheduler(scheduler, tls_ca, tls_cert, tls_key)
    workers = worker_count(jobs, cluster)

    from ..config import parse_overrides
    from ..study import check_count
    from ..study.condition import conditions

    values, overrides = parse_vary(vary or []), parse_overrides(settings or [])
    numbers = parse_seeds(seeds)
    found = conditions(scenario, values, overrides)
    check_count(len(found) * len(numbers), f"{len(found)} combinations with {len(numbers)} seeds each ask")
    attempts = [(condition, seed) for condition in found for seed in numbers]

    from ..study.run import run_study
    from ..study.summary import summarise

    with study_progress(Path(scenario).stem) as progress, saying_what_is_kept("attempts", out):
        store = run_study(
            attempts,
            out,
            jobs=workers,
            scheduler=cluster,
            record=record.value,
            measure=measure,
            configuration=_configuration(scenario, values, overrides),
            progress=progress,
        )
    with store:
        rows = summarise(store, attempts)
        if as_json:
            print_json([row.as_dict() for row in rows])
        else:
            _print_rows(rows, list(values))
            _print_errors(store.attempts(attempts))
            print(f"every attempt is in {store.path}")


def _configuration(scenario: str, vary: Mapping[str, Any], overrides: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values that two sweeps must share to be one study; varied values and seeds may be added later."""
    from ..files import read_toml
    from ..scenarios import find

    table = read_toml(find(scenario))
    shared = {key: value for key, value in table.items() if key not in ("summary", "tags")}
    return {"scenario": shared, "set": dict(overrides), "varied": sorted(vary)}


def _print_rows(rows: Sequence[SummaryRow], varied: list[str]) -> None:
    table = Table(box=None, pad_edge=False)
    for column in varied or ["scenario"]:
        table.add_column(escape(column))
    for column in ("attempts", "successes", "rate", "95 % interval", "several", "F_grasp", "errors"):
        table.add_column(column, justify="right")
    measured = list(dict.fromkeys(name for row in rows for name in row.measures))
    for name in measured:
        table.add_column(escape(name), justify="right")
    for row in rows:
        names = [escape(str(row.condition[key])) for key in varied or ["scenario"]]
        interval = f"{100 * row.ci_low:.0f} to {100 * row.ci_high:.0f} %"
        counts = (row.n, row.successes, f"{100 * row.rate:.0f} %", interval, row.multiple, row.triggered, row.errors)
        means = [f"{row.measures[name]:.4g}" if name in row.measures else "-" for name in measured]
        table.add_row(*names, *map(str, counts), *means)
    make_console().print(table)


def _print_errors(rows: Iterable[AttemptRow]) -> None:
    sentences: dict[str, list[int]] = {}
    for row in rows:
        if row.error is not None:
            sentences.setdefault(row.error, []).append(row.seed)
    for sentence, seeds in list(sentences.items())[:MAX_SHOWN_ERRORS]:
        print(f"seed {seeds[0]}{f' and {len(seeds) - 1} more' if len(seeds) > 1 else ''}: {sentence}", file=sys.stderr)
    if len(sentences) > MAX_SHOWN_ERRORS:
        print(f"and {len(sentences) - MAX_SHOWN_ERRORS} other errors", file=sys.stderr)
