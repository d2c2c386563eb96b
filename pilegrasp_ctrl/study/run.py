"""Runs the missing attempts of a study on workers of this machine or of a cluster, and stores the results."""

from __future__ import annotations

import contextlib
import logging
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

from ..exceptions import ConfigurationError
from ..files import STUDY_FILE, locked, make_folder
from ..plugins import plugin_folders
from . import MAX_JOBS, MAX_SEED, check_count
from .attempt import AttemptReport, WorkItem, load_measure, run_work_item
from .condition import Attempt, Condition
from .dispatch import Pool, dispatch
from .origins import origins_of
from .scheduler import Scheduler
from .store import StudyStore
from .worker_pool import WorkerPool

_LOGGER = logging.getLogger(__name__)

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
    scheduler: Scheduler | str | None = None,
    record: Record = "none",
    measure: str | None = None,
    configuration: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
    pool: Pool | None = None,
) -> StudyStore:
    """Run the attempts that the folder's store does not hold yet, and return the open store.

    An attempt that raises becomes a row with its error. Whatever ends the study, finished attempts are kept, and the
    same call does the rest.

    Args:
        attempts: Conditions and seeds.
        folder: Folder of the study; made if it is missing.
        jobs: Number of worker processes on this machine.
        scheduler: Dask scheduler, or its address; its workers are used instead of processes on this machine.
        record: Attempts of this run that leave a recording: none, those without success, the first seed of each
            condition in `attempts`, or all.
        measure: Name `module:function` of a function `f(recording) -> mapping of JSON values`, whose result becomes
            `result["measures"]`. Workers load it, too, from the folders of `use_plugins`.
        configuration: JSON values that identify the study; a folder that holds other values is refused.
        progress: Callback at the beginning and whenever attempts have finished.
        pool: Workers of `open_pool`, for one call of many; used instead of `jobs` and `scheduler`.

    Raises:
        PilegraspError: A scenario cannot be used, the store was made by another version or for another study, or the
            workers cannot start.
    """
    if record not in get_args(Record):
        raise ConfigurationError(f"record = {record!r} is not known; choose from {', '.join(get_args(Record))}")
    if not 1 <= jobs <= MAX_JOBS:
        raise ConfigurationError(f"jobs = {jobs} must be at least 1 and at most {MAX_JOBS}")
    check_count(len(attempts), "the study asks")
    for _, seed in attempts:
        if not isinstance(seed, int) or not 0 <= seed <= MAX_SEED:
            raise ConfigurationError(f"seed = {seed!r} must be a whole number from 0 to 2^63 - 1")
    if isinstance(scheduler, str):
        scheduler = Scheduler(scheduler)
    if measure is not None:
        load_measure(measure)
    with contextlib.ExitStack() as stack:
        # A scheduler that does not answer is found before models are built and kernels compiled.
        cluster = pool
        if pool is None and scheduler is not None and not _holds_all(Path(folder), attempts):
            cluster = stack.enter_context(open_pool(jobs, scheduler))
        return _run_missing(attempts, Path(folder), jobs, cluster, record, measure, configuration, progress)


def _holds_all(folder: Path, attempts: Sequence[Attempt]) -> bool:
    """Return whether a folder holds a study with all these attempts."""
    if not (folder / STUDY_FILE).is_file():
        return False
    with StudyStore(folder) as store:
        return not store.missing(attempts)


def _run_missing(
    attempts: Sequence[Attempt],
    folder: Path,
    jobs: int,
    cluster: Pool | None,
    record: Record,
    measure: str | None,
    configuration: Mapping[str, Any] | None,
    progress: Progress | None,
) -> StudyStore:
    distinct: dict[str, Condition] = {}
    first: dict[str, int] = {}
    for condition, seed in attempts:
        distinct.setdefault(condition.config_hash, condition)
        first.setdefault(condition.config_hash, seed)
    check_conditions(list(distinct.values()))
    origins = origins_of((condition.scenario for condition in distinct.values()), measure)
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
                    plugin_folders(),
                )
                for condition, seed in missing
            ]
            _run_work_items(store, work_items, owners, attempts, jobs, cluster, progress)
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
    cluster: Pool | None,
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
    workers = open_pool(min(jobs, len(work_items)), None) if cluster is None else contextlib.nullcontext(cluster)
    with workers as pool:
        for batch in dispatch(pool, run_work_item, work_items, _report_death):
            reports = [report for _, report in batch]
            store.add([(owners[report.config_hash, report.seed], report) for report in reports])
            for report in reports:
                ended = report.error or ("success" if report.success else "no success")
                _LOGGER.info("attempt %s, seed %d: %s", report.config_hash, report.seed, ended)
            finished += len(reports)
            successes += sum(report.success for report in reports)
            errors += sum(report.error is not None for report in reports)
            show()


def open_pool(jobs: int, scheduler: Scheduler | None = None) -> AbstractContextManager[Pool]:
    """Return `jobs` processes of this machine, started when they are needed, or the workers of a scheduler."""
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
