"""Runs the missing attempts of a study on workers of this machine or of a cluster, and stores the results."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

from ..exceptions import ConfigurationError
from ..files import locked, make_folder
from .attempt import AttemptReport, WorkItem, load_measure, run_work_item
from .condition import Attempt, Condition
from .dispatch import Pool, dispatch
from .origins import origins_of
from .store import StudyStore
from .worker_pool import WorkerPool

Record = Literal["none", "failures", "first", "all"]
"""Which attempts leave a recording."""


@dataclass(frozen=True, slots=True)
class StudyProgress:
    """The progress of a study.

    Attributes:
        total: Number of attempts that were asked for.
        found: Number of these that an earlier run finished.
        finished: Number of these that this run finished.
        successes: Number of successful attempts in the store.
        errors: Number of attempts in the store that raised.
        seconds: Time since this run began to hand out attempts [s].
    """

    total: int
    found: int
    finished: int
    successes: int
    errors: int
    seconds: float

    @property
    def done(self) -> int:
        """Number of attempts in the store."""
        return self.found + self.finished

    @property
    def rate(self) -> float:
        """Attempts per second of this run; 0 before the first."""
        return self.finished / self.seconds if self.seconds > 0.0 else 0.0

    @property
    def seconds_left(self) -> float | None:
        """Time that the missing attempts take at this rate [s]; None before the first attempt."""
        return (self.total - self.done) / self.rate if self.rate else None


Progress = Callable[[StudyProgress], None]
"""A callback that gets the progress of a study."""


def run_study(
    attempts: Sequence[Attempt],
    folder: str | Path,
    *,
    jobs: int = 2,
    scheduler: str | None = None,
    record: Record = "none",
    measure: str | None = None,
    configuration: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
) -> StudyStore:
    """Run the attempts that the folder's store does not hold yet, and return the open store.

    An attempt that raises becomes a row with its error. Whatever ends the study, finished attempts are kept, and the
    same call does the rest.

    Args:
        attempts: Conditions and seeds.
        folder: Folder of the study; made if it is missing.
        jobs: Number of worker processes on this machine.
        scheduler: Address of a dask scheduler; its workers are used instead of processes on this machine.
        record: Attempts of this run that leave a recording: none, those without success, the first seed of each
            condition in `attempts`, or all.
        measure: Dotted name of a function `f(recording) -> mapping of JSON values`, whose result becomes
            `result["measures"]`; workers import it.
        configuration: JSON values that identify the study; a folder that holds other values is refused.
        progress: Callback at the beginning and whenever attempts have finished.

    Raises:
        PilegraspError: A scenario cannot be used, the store was made by another version or for another study, or the
            workers cannot start.
    """
    if record not in get_args(Record):
        raise ConfigurationError(f"record = {record!r} is not known; choose from {', '.join(get_args(Record))}")
    if jobs < 1:
        raise ConfigurationError(f"jobs = {jobs} must be at least 1")
    for _, seed in attempts:
        if not isinstance(seed, int) or not 0 <= seed < 2**63:
            raise ConfigurationError(f"seed = {seed!r} must be a whole number from 0 to 2^63 - 1")
    if measure is not None:
        load_measure(measure)
    distinct: dict[str, Condition] = {}
    first: dict[str, int] = {}
    for condition, seed in attempts:
        distinct.setdefault(condition.config_hash, condition)
        first.setdefault(condition.config_hash, seed)
    check_conditions(list(distinct.values()))
    origins = origins_of((condition.scenario for condition in distinct.values()), measure)
    folder = Path(folder)
    make_folder(folder)
    with locked(folder, "study"):
        store = StudyStore(folder, create=True)
        try:
            store.adopt(distinct.values(), origins, configuration)
            missing = store.missing(attempts)
            owners = {(condition.config_hash, seed): condition for condition, seed in missing}
            work_items = [
                WorkItem(
                    condition.placed,
                    condition.config_hash,
                    seed,
                    _record_of(record, seed == first[condition.config_hash]),
                    measure,
                    origins,
                )
                for condition, seed in missing
            ]
            _run_work_items(store, work_items, owners, attempts, jobs, scheduler, progress)
        except BaseException:
            store.close()
            raise
    return store


def check_conditions(conditions: Sequence[Condition]) -> None:
    """Refuse scenarios that cannot run, before the first attempt starts.

    Raises:
        ConfigurationError: At least one scenario cannot run; one sentence names every reason.
    """
    from ..programs.attempt import check

    wrong: dict[str, None] = {}
    for condition in conditions:
        try:
            check(condition.scenario)
        except ConfigurationError as error:
            wrong[str(error)] = None
    if wrong:
        raise ConfigurationError("; ".join(wrong))


def _run_work_items(
    store: StudyStore,
    work_items: list[WorkItem],
    owners: Mapping[tuple[str, int], Condition],
    attempts: Sequence[Attempt],
    jobs: int,
    scheduler: str | None,
    progress: Progress | None,
) -> None:
    rows = store.attempts(attempts)
    found, successes, errors = len(rows), sum(row.success for row in rows), sum(row.error is not None for row in rows)
    start, finished = time.monotonic(), 0

    def show() -> None:
        if progress is not None:
            seconds = time.monotonic() - start
            progress(StudyProgress(found + len(work_items), found, finished, successes, errors, seconds))

    show()
    if not work_items:
        return
    with _pool(min(jobs, len(work_items)), scheduler) as pool:
        for batch in dispatch(pool, run_work_item, work_items, _report_death):
            reports = [report for _, report in batch]
            store.add([(owners[report.config_hash, report.seed], report) for report in reports])
            finished += len(reports)
            successes += sum(report.success for report in reports)
            errors += sum(report.error is not None for report in reports)
            show()


def _pool(jobs: int, scheduler: str | None) -> AbstractContextManager[Pool]:
    if scheduler is None:
        return WorkerPool(jobs)
    from .cluster_pool import ClusterPool

    return ClusterPool(scheduler)


def _record_of(record: Record, first: bool) -> str:
    if record == "failures":
        return "failures"
    return "yes" if record == "all" or (record == "first" and first) else "no"


def _report_death(item: WorkItem, times: int) -> AttemptReport:
    error = f"the worker process died {times} times while it ran this attempt, perhaps because memory was too small"
    return AttemptReport(item.config_hash, item.seed, None, error)
