"""`pilegrasp paper`."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn
from rich.table import Table

from ..plugins import use_plugins
from ..study import FIRST_FRESH_SEED, FIRST_JUDGING_SEED, MAX_SEED
from .application import DebugOption, JsonOption, PluginsOption, app, make_console, print_json, with_examples
from .progress import make_progress
from .study_options import (
    JobsOption,
    SchedulerOption,
    TlsCaOption,
    TlsCertOption,
    TlsKeyOption,
    read_scheduler,
    saying_what_is_kept,
    study_progress,
    worker_count,
)

if TYPE_CHECKING:
    from ..scenarios.paper.plan import PlannedCondition, Remaining

COLOURS = {"holds": "green", "fails": "red", "undecided": "yellow", "calibrated": "magenta"}
"""Colour of each verdict in the terminal; others have none."""


@app.command(
    "paper",
    epilog=with_examples(
        "Run it again with the same folder, and it runs only the missing attempts; more experiments or attempts are "
        "added. An interrupt loses no finished attempt.",
        "pilegrasp paper fig08 --attempts 10 --out results",
        "pilegrasp paper all --dry-run --out results",
    ),
)
def paper(
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder of the study; made if it is missing.")],
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[NAME]...",
            help="Which experiments: fig06 to fig11, velocity_force, motion_pattern, table1, few_balls, flat_plate, "
            "loose_pile, brittle_axes, noisy_sensor, or all, which is the default.",
        ),
    ] = None,
    attempts: Annotated[
        int | None,
        typer.Option(
            min=1,
            metavar="N",
            help="Largest number of attempts at a condition; by default those of the ledger, 15 to 100.",
        ),
    ] = None,
    jobs: JobsOption = None,
    scheduler: SchedulerOption = None,
    tls_ca: TlsCaOption = None,
    tls_cert: TlsCertOption = None,
    tls_key: TlsKeyOption = None,
    seeds_from: Annotated[
        int,
        typer.Option(
            min=0,
            max=MAX_SEED,
            metavar="SEED",
            help=f"First seed of every condition; below {FIRST_JUDGING_SEED} to try things out.",
        ),
    ] = FIRST_FRESH_SEED,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Change a key of every condition; may be repeated."),
    ] = None,
    recordings: Annotated[
        bool, typer.Option("--recordings/--no-recordings", help="Whether to make pages of typical attempts.")
    ] = True,
    dry_run: Annotated[
        bool,
        typer.Option("--dry-run", metavar="", help="Print the number of missing attempts and their time, and stop."),
    ] = False,
    plugins: PluginsOption = None,
    as_json: JsonOption = False,
    debug: DebugOption = False,
) -> None:
    """Run the paper's experiments and judge its claims: claims.json, index.html, figures, recordings."""
    use_plugins(plugins or ())
    cluster = read_scheduler(scheduler, tls_ca, tls_cert, tls_key)
    workers = worker_count(jobs, cluster)

    from ..config import parse_overrides
    from ..scenarios.paper.plan import EXPERIMENTS, find_experiment, plan

    named = {name: find_experiment(name) for name in names or () if name != "all"}
    every = not names or "all" in names
    changes = parse_overrides(settings or [])
    planned = plan((EXPERIMENTS if every else named).values(), attempts, changes)
    remaining = _remaining(planned, seeds_from, out)
    print(_describe(remaining, len(planned), None if cluster else workers), file=sys.stderr, flush=True)
    if dry_run:
        if as_json:
            print_json(_costs(planned, remaining))
        else:
            _print_costs(planned)
        return

    from ..scenarios.paper.run import run_paper, write_results

    with study_progress("paper") as progress, saying_what_is_kept("attempts", out):
        store = run_paper(
            planned, out, seeds_from, jobs=workers, scheduler=cluster, settings=changes, progress=progress
        )
    with store, _pages() as shown:
        command = _command(names, attempts, seeds_from, settings or [], out)
        document = write_results(
            store,
            command,
            seeds_from,
            attempts=attempts,
            settings=changes,
            recordings=recordings,
            progress=shown,
        )
    if as_json:
        print_json(document)
    else:
        _print_claims(document, out, [] if every else list(named))


def _remaining(planned: list[PlannedCondition], first_seed: int, out: Path) -> Remaining:
    from ..files import STUDY_FILE
    from ..scenarios.paper.plan import count_remaining
    from ..study.store import StudyStore

    if not (out / STUDY_FILE).is_file():
        return count_remaining(planned, first_seed)
    with StudyStore(out) as store:
        return count_remaining(planned, first_seed, store)


def _describe(remaining: Remaining, conditions: int, workers: int | None) -> str:
    text = f"{remaining.attempts} attempts at {conditions} conditions, {remaining.missing} of them missing"
    if not remaining.missing:
        return text
    text += f": about {remaining.seconds / 60.0:.0f} min of processor time"
    return text if workers is None else f"{text}, {remaining.seconds / 60.0 / workers:.0f} min on {workers} processes"


def _by_experiment(planned: list[PlannedCondition]) -> dict[str, tuple[int, int, float]]:
    """Return conditions, attempts and processor seconds of each experiment; a shared condition counts for the first."""
    found: dict[str, tuple[int, int, float]] = {}
    for part in planned:
        conditions, attempts, seconds = found.get(part.experiment, (0, 0, 0.0))
        found[part.experiment] = (conditions + 1, attempts + part.attempts, seconds + part.attempts * part.cost())
    return found


def _costs(planned: list[PlannedCondition], remaining: Remaining) -> dict[str, Any]:
    rows = _by_experiment(planned)
    return {
        "attempts": remaining.attempts,
        "missing": remaining.missing,
        "processor_seconds": remaining.seconds,
        "experiments": {
            name: {"conditions": conditions, "attempts": attempts, "processor_seconds": seconds}
            for name, (conditions, attempts, seconds) in rows.items()
        },
    }


def _print_costs(planned: list[PlannedCondition]) -> None:
    table = Table(box=None, pad_edge=False)
    table.add_column("experiment")
    for column in ("conditions", "attempts", "processor time"):
        table.add_column(column, justify="right")
    for name, (conditions, attempts, seconds) in _by_experiment(planned).items():
        table.add_row(escape(name), str(conditions), str(attempts), f"{seconds / 60.0:.1f} min")
    make_console().print(table)


def _command(names: list[str] | None, attempts: int | None, first_seed: int, settings: list[str], out: Path) -> str:
    """Return the command that repeats this study."""
    words = ["pilegrasp", "paper", *(names or ["all"])]
    words += [] if attempts is None else ["--attempts", str(attempts)]
    words += [] if first_seed == FIRST_FRESH_SEED else ["--seeds-from", str(first_seed)]
    words += [word for setting in settings for word in ("--set", setting)]
    return shlex.join([*words, "--out", str(out)])


@contextmanager
def _pages() -> Iterator[Callable[[int, int], None]]:
    """Show how many typical attempts have been recorded."""
    columns = (TextColumn("{task.description}"), BarColumn(bar_width=24), MofNCompleteColumn())
    with make_progress(*columns) as bar:
        line = bar.add_task("recordings", total=None)
        yield lambda done, total: bar.update(line, completed=done, total=total)


def _print_claims(document: Mapping[str, Any], out: Path, named: Sequence[str]) -> None:
    """Print the ledger; of some experiments, their figures and the claims that have attempts."""
    rows = [row for row in (*document["claims"], *document["nulls"]) if not named or _has_attempts(row)]
    table = Table(box=None, pad_edge=False)
    for column in ("", "verdict", "repeats", "claim"):
        table.add_column(column)
    for row in rows:
        verdict = row["verdict"] or "no verdict"
        repeats = "" if row["repeats"] is None else f"{100.0 * row['repeats']:.0f} %"
        colour = COLOURS.get(verdict, "default")
        table.add_row(row["id"], f"[{colour}]{verdict}[/]", repeats, escape(row["claim"]))
    console = make_console()
    console.print(table)
    for row in rows if named else ():
        for part in row["parts"]:
            console.print(f"{row['id']}: {escape(part['statement'])}", highlight=False, soft_wrap=True)
    if document["missing"]:
        console.print(
            f"no verdict before the last attempt of `all`: {document['missing']} are missing", highlight=False
        )
    figures = [name for each in named for name in document["figures"].get(each, ())]
    for name in (*figures, "claims.json", "index.html"):
        console.print(f"wrote {escape(str(out / name))}", highlight=False, soft_wrap=True)


def _has_attempts(row: Mapping[str, Any]) -> bool:
    return any(counts["n"] for counts in row["conditions"].values())
