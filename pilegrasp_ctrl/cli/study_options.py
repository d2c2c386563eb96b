"""The options of the verbs that run many attempts: seeds, varied values, workers, and their progress bar."""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn

from ..exceptions import ConfigurationError
from ..settings import parse_values
from ..study import MAX_JOBS, MAX_SEED, check_count
from .progress import make_progress

if TYPE_CHECKING:
    from ..study.run import StudyProgress
    from ..study.scheduler import Scheduler

JobsOption = Annotated[
    int | None,
    typer.Option("--jobs", min=1, max=MAX_JOBS, metavar="N", help="Worker processes; by default one for each core."),
]
SchedulerOption = Annotated[
    str | None,
    typer.Option("--scheduler", metavar="tcp://HOST:PORT", help="Use the workers of this dask scheduler instead."),
]
TlsCaOption = Annotated[
    Path | None,
    typer.Option("--tls-ca", metavar="F.pem", help="Authority that signed the certificate of a tls:// scheduler."),
]
TlsCertOption = Annotated[
    Path | None, typer.Option("--tls-cert", metavar="F.pem", help="Your certificate, for a tls:// scheduler.")
]
TlsKeyOption = Annotated[
    Path | None, typer.Option("--tls-key", metavar="F.pem", help="Your key, if it is not in the file of --tls-cert.")
]


def read_scheduler(
    address: str | None, tls_ca: Path | None, tls_cert: Path | None, tls_key: Path | None
) -> Scheduler | None:
    """Return the scheduler that the options name, or None.

    Raises:
        ConfigurationError: The address has another form, or the certificates do not belong to it.
    """
    files = [None if file is None else str(file) for file in (tls_ca, tls_cert, tls_key)]
    if address is None:
        if any(files):
            raise ConfigurationError("--tls-ca, --tls-cert and --tls-key are for --scheduler; give its address too")
        return None
    from ..study.scheduler import Scheduler

    return Scheduler(address, *files)


def worker_count(jobs: int | None, scheduler: Scheduler | None) -> int:
    """Return the number of processes on this machine: the number that was asked for, or one for each usable core.

    Raises:
        ConfigurationError: Workers of a cluster were asked for as well.
    """
    if scheduler is not None and jobs is not None:
        raise ConfigurationError("--jobs is for this machine and --scheduler for a cluster; leave out one of the two")
    if jobs is not None:
        return jobs
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def parse_seeds(text: str) -> range:
    """Read `FIRST:LAST`, the last one left out, or one number.

    Raises:
        ConfigurationError: The text has another form, or names no seed or too many.
    """
    first, colon, last = text.partition(":")
    try:
        seeds = range(int(first), int(last) if colon else int(first) + 1)
    except ValueError:
        seeds = range(0)
    if not seeds or seeds[0] < 0:
        raise ConfigurationError(
            f"--seeds {text!r:.80} must be FIRST:LAST, the last one left out, such as 0:3 for 0, 1, 2"
        )
    if seeds[-1] > MAX_SEED:
        raise ConfigurationError(f"--seeds {text!r:.80}: the largest seed is {MAX_SEED}, 2^63 - 1")
    check_count(seeds.stop - seeds.start, f"--seeds {text!r:.80} asks")
    return seeds


def parse_vary(texts: Iterable[str]) -> dict[str, list[Any]]:
    """Read `key=a,b,c` texts; the values are TOML if they parse as TOML, and bare strings otherwise.

    Raises:
        ConfigurationError: A text has no `=`, no key or no value, a key comes twice, or a part of a value would be
            ignored.
    """
    found: dict[str, list[Any]] = {}
    for text in texts:
        key, separator, values = (part.strip() for part in text.partition("="))
        if not separator or not key or not values:
            raise ConfigurationError(
                f"--vary {text!r:.80} is not of the form key=a,b,c, as in --vary pile.count=5,10,20"
            )
        if key in found:
            raise ConfigurationError(f"--vary {key} is given twice; put all its values behind one")
        try:
            found[key] = parse_values(values)
        except ConfigurationError as error:
            raise ConfigurationError(f"--vary {text!r:.80}: {error}") from None
    return found


@contextmanager
def saying_what_is_kept(finished: str, out: Path) -> Iterator[None]:
    """On an interrupt, say that what is finished, such as "attempts", is kept in a folder."""
    try:
        yield
    except KeyboardInterrupt:
        print(f"stopped; finished {finished} are kept in {out}; the same command runs the rest", file=sys.stderr)
        raise


@contextmanager
def study_progress(name: str) -> Iterator[Callable[[StudyProgress], None]]:
    """Show the attempts that are done, their rate, the time left and the success so far."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(bar_width=24),
        MofNCompleteColumn(),
        TextColumn("{task.fields[state]}"),
    )
    with make_progress(*columns) as bar:
        line = bar.add_task(escape(name), total=None, state="preparing")
        yield lambda study: bar.update(line, completed=study.done, total=study.total, state=describe_progress(study))


def describe_progress(study: StudyProgress) -> str:
    """Return rate, time left and success so far as one line."""
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


@contextmanager
def search_progress(name: str, finished: str, out: Path) -> Iterator[Callable[[str, int, int, str], None]]:
    """Show the step of a search, what is finished of it, the rate, the time left and a note; say what a stop keeps.

    The function that is returned takes the step, the finished and the expected number, and a note; "" keeps the former.
    Outside a terminal it prints a line now and then.

    Args:
        name: What is searched for.
        finished: What is finished one by one, such as "attempts".
        out: Folder in which it is kept.
    """
    columns = (
        TextColumn("{task.description}"),
        BarColumn(bar_width=24),
        MofNCompleteColumn(),
        TextColumn("{task.fields[rate]}"),
        TimeRemainingColumn(),
        TextColumn("{task.fields[note]}"),
    )
    with make_progress(*columns) as bar:
        line = bar.add_task(escape(f"{name}: preparing"), total=None, rate="", note="")
        kept = ""

        def show(step: str, done: int, total: int, note: str = "") -> None:
            nonlocal kept
            kept = note or kept
            words = escape(f"{name}: {step}")
            if total != bar.tasks[0].total:
                # The speed of another part is none of this one; `reset` forgets the fields that it is not given.
                bar.reset(line, total=total, completed=done, description=words, rate="", note=escape(kept))
            speed = bar.tasks[0].speed
            rate = f"{60.0 * speed:.0f}/min" if speed else ""
            bar.update(line, completed=done, total=total, description=words, rate=rate, note=escape(kept))

        with saying_what_is_kept(finished, out):
            yield show


def repeat_command(verb: str, scenario: str, options: Mapping[str, Any], out: Path) -> str:
    """Return the command that repeats a search; an option without a value is left out, one with a list is repeated."""
    words = ["pilegrasp", verb, scenario]
    for name, value in options.items():
        for each in value if isinstance(value, list) else [value]:
            words += [] if each is None else [name, str(each)]
    return shlex.join([*words, "--out", str(out)])
