"""Carry out a study: what is missing, on workers here or elsewhere, into the store."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

from ..exceptions import ConfigurationError
from .attempt import AttemptReport, WorkItem, load_measure, run_work_item
from .condition import Condition
from .dispatch import Pool, dispatch
from .folder_lock import locked
from .origins import origins_of
from .store import StudyStore, make_folder
from .worker_pool import WorkerPool

Record = Literal["none", "failures", "first", "all"]


@dataclass(frozen=True, slots=True)
class StudyProgress:
    """What is done, and how it went so far.

    Attributes:
        total: attempts that were asked for.
        found: of these, those that a run before this one had finished.
        finished: of these, those that this run has finished.
        successes: among all that are there.
        errors: likewise, attempts that raised.
        seconds: since this run handed out its first attempt [s].
    """

    total: int
    found: int
    finished: int
    successes: int
    errors: int
    seconds: float

    @property
    def done(self) -> int:
        """Attempts that are there."""
        return self.found + self.finished

    @property
    def rate(self) -> float:
        """Attempts a second of this run; 0 before the first."""
        return self.finished / self.seconds if self.seconds > 0.0 else 0.0

    @property
    def seconds_left(self) -> float | None:
        """Time that the rest takes at this rate [s]; None before the first attempt."""
        return (self.total - self.done) / self.rate if self.rate else None


Progress = Callable[[StudyProgress], None]


def run_study(
    tasks: Sequence[tuple[Condition, int]],
    folder: str | Path,
    *,
    jobs: int = 2,
    scheduler: str | None = None,
    record: Record = "none",
    measure: str | None = None,
    configuration: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
) -> StudyStore:
    """Carry out the attempts that the folder's store does not hold yet, and return the store, open.

    An attempt that raises is a row with its error. Whatever ends the study, what is finished is kept, and the same call
    does the rest.

    Args:
        tasks: conditions and seeds.
        folder: of the study; made where it is missing.
        jobs: worker processes on this machine.
        scheduler: address of a dask scheduler, whose workers are then used instead.
        record: which of the attempts that are carried out leave a recording: none, those without success, the first
            seed of each condition in `tasks`, or all.
        measure: dotted name of a function `f(recording) -> mapping of JSON values`, whose result becomes
            `result["measures"]`; workers import it.
        configuration: JSON values by which a study in the folder is told from another one.
        progress: called at the beginning and whenever attempts have finished.

    Raises:
        PilegraspError: where a scenario cannot be used, the store was made by another version or for another study, or
            workers cannot start.
    """
    if record not in get_args(Record):
        raise ConfigurationError(f"record = {record!r} is not known; choose from {', '.join(get_args(Record))}")
    if jobs < 1:
        raise ConfigurationError(f"jobs = {jobs} must be at least 1")
    for _, seed in tasks:
        if not isinstance(seed, int) or not 0 <= seed < 2**63:
            raise ConfigurationError(f"seed = {seed!r} must be a whole number from 0 to 2^63 - 1")
    if measure is not None:
        load_measure(measure)
    distinct: dict[str, Condition] = {}
    first: dict[str, int] = {}
    for condition, seed in tasks:
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
            missing = store.missing(tasks)
            owners = {(condition.config_hash, seed): condition for condition, seed in missing}
            orders = [
                WorkItem(
                    condition.placed,
                    condition.config_hash,
                    seed,
                    _recorded(record, seed == first[condition.config_hash]),
                    measure,
                    origins,
                )
                for condition, seed in missing
            ]
            _run_work_items(store, orders, owners, tasks, jobs, scheduler, progress)
        except BaseException:
            store.close()
            raise
    return store


def check_conditions(conditions: Sequence[Condition]) -> None:
    """Find out what can be found out about scenarios before anything runs.

    Raises:
        ConfigurationError: one sentence on all of them.
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
    orders: list[WorkItem],
    owners: Mapping[tuple[str, int], Condition],
    tasks: Sequence[tuple[Condition, int]],
    jobs: int,
    scheduler: str | None,
    progress: Progress | None,
) -> None:
    rows = store.attempts(tasks)
    found, successes, errors = len(rows), sum(row.success for row in rows), sum(row.error is not None for row in rows)
    start, finished = time.monotonic(), 0

    def show() -> None:
        if progress is not None:
            seconds = time.monotonic() - start
            progress(StudyProgress(found + len(orders), found, finished, successes, errors, seconds))

    show()
    if not orders:
        return
    with _pool(min(jobs, len(orders)), scheduler) as pool:
        for batch in dispatch(pool, run_work_item, orders, _worker_died):
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


def _recorded(record: Record, first: bool) -> str:
    if record == "failures":
        return "failures"
    return "yes" if record == "all" or (record == "first" and first) else "no"


def _worker_died(task: WorkItem, times: int) -> AttemptReport:
    error = f"the worker process died {times} times while it ran this attempt, perhaps for want of memory"
    return AttemptReport(task.config_hash, task.seed, None, error)
