"""`pilegrasp sweep`."""

from __future__ import annotations

import os
import sys
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn
from rich.table import Table

from ..exceptions import ConfigurationError
from .application import app
from .options import DebugOption, JsonOption, make_console, make_progress, print_json

if TYPE_CHECKING:
    from ..study.attempt import AttemptRow
    from ..study.run import StudyProgress
    from ..study.summary import SummaryRow

JobsOption = Annotated[
    int | None, typer.Option("--jobs", min=1, metavar="N", help="Worker processes; one for each core where absent.")
]
SchedulerOption = Annotated[
    str | None,
    typer.Option("--scheduler", metavar="ADDRESS", help="Use the workers of this dask scheduler instead."),
]

MOST_ERRORS = 3
"""So many different sentences of attempts that raised are shown; the store has all."""


class Recorded(StrEnum):
    """Which attempts leave a recording."""

    none = "none"
    failures = "failures"
    first = "first"
    all = "all"


@app.command(
    "sweep",
    epilog="Run it again with the same options and it does only what is missing; more seeds or values are added to "
    "what is there. An interrupt loses no finished attempt. `pilegrasp export DIR table.csv` writes them as a table.",
)
def sweep(
    scenario: Annotated[
        str,
        typer.Argument(metavar="NAME|FILE.toml", help="A scenario that `pilegrasp list` shows, or a file of your own."),
    ],
    seeds: Annotated[str, typer.Option(metavar="FIRST:LAST", help="Seeds of each combination, the last one left out.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder of the study; made where it is missing.")],
    vary: Annotated[
        list[str] | None,
        typer.Option(metavar="KEY=A,B,C", help="Values of a key; repeated, every combination is run."),
    ] = None,
    jobs: JobsOption = None,
    scheduler: SchedulerOption = None,
    record: Annotated[
        Recorded,
        typer.Option(
            metavar="none|failures|first|all", help="Which attempts leave a recording; first: one a combination."
        ),
    ] = Recorded.none,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Change a key for all of them; may be repeated."),
    ] = None,
    as_json: JsonOption = False,
    debug: DebugOption = False,
) -> None:
    """Carry out every combination of the varied keys with every seed, and count the successes."""
    workers = worker_count(jobs, scheduler)

    from ..config import parse_overrides
    from ..study.condition import conditions

    values, overrides = parse_vary(vary or []), parse_overrides(settings or [])
    numbers = parse_seeds(seeds)
    found = conditions(scenario, values, overrides)
    tasks = [(condition, seed) for condition in found for seed in numbers]

    from ..study.run import run_study
    from ..study.summary import summarise

    with study_progress(Path(scenario).stem) as progress:
        try:
            store = run_study(
                tasks,
                out,
                jobs=workers,
                scheduler=scheduler,
                record=record.value,
                configuration=_configuration(scenario, values, overrides),
                progress=progress,
            )
        except KeyboardInterrupt:
            print(f"stopped; what is finished is kept in {out}, and the same command does the rest", file=sys.stderr)
            raise
    with store:
        rows = summarise(store, tasks)
        if as_json:
            print_json([row.as_dict() for row in rows])
        else:
            _print_rows(rows, list(values))
            _print_errors(store.attempts(tasks))
            print(f"every attempt is in {store.path}")


def worker_count(jobs: int | None, scheduler: str | None) -> int:
    """Return how many processes to use on this machine: those asked for, or one for each core that may be used.

    Raises:
        ConfigurationError: where a cluster's workers are asked for as well.
    """
    if scheduler is not None and jobs is not None:
        raise ConfigurationError("--jobs is for this machine and --scheduler for a cluster; leave out one of the two")
    if jobs is not None:
        return jobs
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def parse_vary(texts: Iterable[str]) -> dict[str, list[Any]]:
    """Read `key=a,b,c` texts; the values are TOML where they parse as TOML and bare strings otherwise.

    Raises:
        ConfigurationError: where a text has no `=`, no key or no value, or a key comes twice.
    """
    found: dict[str, list[Any]] = {}
    for text in texts:
        key, separator, values = (part.strip() for part in text.partition("="))
        if not separator or not key or not values:
            raise ConfigurationError(f"--vary {text!r} is not of the form key=a,b,c, as in --vary pile.count=5,10,20")
        if key in found:
            raise ConfigurationError(f"--vary {key} is given twice; put all its values behind one")
        found[key] = _values(values)
    return found


def _values(text: str) -> list[Any]:
    try:
        return list(tomllib.loads(f"values = [{text}]")["values"])
    except tomllib.TOMLDecodeError:
        return [_value(part.strip()) for part in text.split(",")]


def _value(text: str) -> Any:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


def parse_seeds(text: str) -> range:
    """Read `FIRST:LAST`, the last one left out, or one number.

    Raises:
        ConfigurationError: where it is something else, or there is no seed.
    """
    first, colon, last = text.partition(":")
    try:
        numbers = range(int(first), int(last) if colon else int(first) + 1)
    except ValueError:
        numbers = range(0)
    if not numbers or numbers[0] < 0:
        raise ConfigurationError(f"--seeds {text!r} must be FIRST:LAST, the last one left out, such as 0:50")
    return numbers


def _configuration(scenario: str, vary: Mapping[str, Any], overrides: Mapping[str, Any]) -> dict[str, Any]:
    """Return what makes two sweeps one study; values and seeds may be added to it."""
    from ..scenarios import find

    table = tomllib.loads(find(scenario).read_text(encoding="utf-8-sig"))
    said = {key: value for key, value in table.items() if key not in ("summary", "tags")}
    return {"scenario": said, "set": dict(overrides), "varied": sorted(vary)}


@contextmanager
def study_progress(name: str) -> Iterator[Callable[[StudyProgress], None]]:
    """Show what is done, its rate, the time left and the successes so far; nothing where nobody watches."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(bar_width=24),
        MofNCompleteColumn(),
        TextColumn("{task.fields[state]}"),
    )
    with make_progress(*columns) as bar:
        task = bar.add_task(escape(name), total=None, state="preparing")
        yield lambda study: bar.update(task, completed=study.done, total=study.total, state=describe(study))


def describe(study: StudyProgress) -> str:
    """Return rate, time left and running success as one line."""
    parts = []
    if study.seconds_left is not None:
        parts.append(f"{60.0 * study.rate:.3g}/min")
        minutes, seconds = divmod(round(study.seconds_left), 60)
        hours, minutes = divmod(minutes, 60)
        parts.append(f"{hours}:{minutes:02}:{seconds:02} left")
    if study.done:
        parts.append(f"success {study.successes / study.done:.0%}")
    if study.errors:
        parts.append(f"{study.errors} errors")
    return ", ".join(parts) or "first attempts"


def _print_rows(rows: Sequence[SummaryRow], varied: list[str]) -> None:
    table = Table(box=None, pad_edge=False)
    for column in varied or ["scenario"]:
        table.add_column(escape(column))
    for column in ("attempts", "successes", "rate", "95 % interval", "several", "F_grasp", "errors"):
        table.add_column(column, justify="right")
    for row in rows:
        names = [escape(str(row.condition[key])) for key in varied or ["scenario"]]
        interval = f"{100 * row.ci_low:.0f} to {100 * row.ci_high:.0f} %"
        counts = (row.n, row.successes, f"{100 * row.rate:.0f} %", interval, row.multiple, row.triggered, row.errors)
        table.add_row(*names, *map(str, counts))
    make_console().print(table)


def _print_errors(rows: Iterable[AttemptRow]) -> None:
    sentences: dict[str, list[int]] = {}
    for row in rows:
        if row.error is not None:
            sentences.setdefault(row.error, []).append(row.seed)
    for sentence, seeds in list(sentences.items())[:MOST_ERRORS]:
        print(f"seed {seeds[0]}{f' and {len(seeds) - 1} more' if len(seeds) > 1 else ''}: {sentence}", file=sys.stderr)
    if len(sentences) > MOST_ERRORS:
        print(f"and {len(sentences) - MOST_ERRORS} other errors", file=sys.stderr)
