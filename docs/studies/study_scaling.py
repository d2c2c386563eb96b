"""Print the cost of an attempt for a worker and for the parent, and how many workers one parent can serve.

Usage: python docs/studies/study_scaling.py [NAME [KEY=VALUE]...]
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import partial
from typing import Any

from pilegrasp_ctrl.config import Scenario, load_scenario, parse_overrides
from pilegrasp_ctrl.statistics import markdown_row, markdown_table
from pilegrasp_ctrl.study.attempt import AttemptReport, WorkItem, run_work_item
from pilegrasp_ctrl.study.condition import Condition
from pilegrasp_ctrl.study.dispatch import Pool, dispatch
from pilegrasp_ctrl.study.origins import origins_of
from pilegrasp_ctrl.study.store import StudyStore
from pilegrasp_ctrl.study.worker_pool import WorkerPool
from script import run_script

JOBS = (1, 2)
"""Numbers of worker processes in the measurement; chosen."""

WORKERS = (1, 2, 10, 100, 1000)
"""Numbers of workers with a projected rate; chosen."""

ATTEMPTS = 8
"""Attempts of each worker, after a first one that does not count [-]; chosen."""

EMPTY = 500
"""Work items without an attempt, which measure the parent's own work [-]; chosen."""

RESULT_BYTES = 900
"""Length of the result of a grasp as JSON [bytes]."""


@dataclass(frozen=True, slots=True)
class Cost:
    """The cost of attempts with some workers.

    Attributes:
        workers: Number of workers.
        attempts: Number of attempts that were counted.
        wall: Wall-clock time from the first to the last of them [s].
        worker: Processor time of an attempt [s].
        parent: Processor time of the parent for each attempt [s].
    """

    workers: int
    attempts: int
    wall: float
    worker: float
    parent: float

    @property
    def per_minute(self) -> float:
        """Attempts per minute."""
        return 60.0 * self.attempts / self.wall


def report_at_once(item: WorkItem) -> AttemptReport:
    """Return at once a report with as much text as that of an attempt."""
    result = json.dumps({"success": True, "grasped": 1, "outcomes": [], "filling": "x" * RESULT_BYTES})
    return AttemptReport(item.config_hash, item.seed, result, None, True)


def measure(
    pool: AbstractContextManager[Pool], workers: int, function: Any, scenario: Scenario, each: int, warm: int = 1
) -> Cost:
    """Run `each` attempts of every worker and store them, as a study does.

    Each worker first runs `warm` attempts that do not count, because the first one imports the engines.
    """
    condition = Condition(scenario, {})
    origins = origins_of([scenario])
    make_item = partial(WorkItem, scenario, condition.config_hash, record="no", measure=None, origins=origins)
    with tempfile.TemporaryDirectory() as folder, StudyStore(folder, create=True) as store, pool as entered:
        store.adopt([condition], origins)
        seeds = range(workers * (each + warm))

        def run_these(seeds: Sequence[int]) -> list[AttemptReport]:
            reports: list[AttemptReport] = []
            for batch in dispatch(entered, function, [make_item(seed) for seed in seeds], _no_report):
                found = [report for _, report in batch]
                store.add([(condition, report) for report in found])
                reports += found
            return reports

        run_these(seeds[: workers * warm])
        wall, parent = time.perf_counter(), time.process_time()
        reports = run_these(seeds[workers * warm :])
        wall, parent = time.perf_counter() - wall, time.process_time() - parent
    worker = sum(report.processor_time for report in reports) / len(reports)
    return Cost(workers, len(reports), wall, worker, parent / len(reports))


def projected(workers: int, attempt: float, parent: float) -> float:
    """Return the attempts per minute that the workers run or the parent stores, whichever are fewer.

    Args:
        workers: Number of workers, each with its own core.
        attempt: Time of an attempt on such a core [s].
        parent: Time of the parent for each attempt [s].
    """
    return 60.0 * min(workers / attempt, 1.0 / parent)


def _no_report(item: WorkItem, deaths: int) -> AttemptReport:
    raise RuntimeError(f"a worker died {deaths} times")


def _cluster(workers: int) -> tuple[Any, AbstractContextManager[Pool]]:
    from distributed import LocalCluster

    from pilegrasp_ctrl.study.cluster_pool import ClusterPool

    cluster = LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None)
    return cluster, ClusterPool(cluster.scheduler_address)


def _print(label: str, cost: Cost) -> None:
    numbers = (f"{cost.per_minute:.1f}", f"{cost.worker:.2f}", f"{1000 * cost.parent:.1f}")
    cells = (label, cost.workers, cost.attempts, *numbers, f"{1000 * cost.wall / cost.attempts:.1f}")
    print(markdown_row(cells), flush=True)


def main(name: str = "free_space_line", *overrides: str) -> None:
    """Measure attempts of scenario NAME with OVERRIDES (KEY=VALUE), and print both tables."""
    scenario = load_scenario(name, parse_overrides(overrides))
    names = ("", "workers", "attempts", "a minute", "worker [s]", "parent [ms]", "wall time / attempts [ms]")
    print(markdown_table(names))
    attempt = 0.0
    for jobs in JOBS:
        cost = measure(WorkerPool(jobs), jobs, run_work_item, scenario, ATTEMPTS)
        attempt = attempt or cost.worker
        _print(" ".join([name, *overrides]), cost)
    bare = measure(WorkerPool(2), 2, report_at_once, scenario, EMPTY)
    _print("no attempt", bare)
    parents = {"processes": bare}
    try:
        cluster, pool = _cluster(2)
    except ImportError:
        print("distributed is not installed, so no cluster is measured", file=sys.stderr)
    else:
        with cluster:
            parents["cluster"] = measure(pool, 2, report_at_once, scenario, EMPTY)
        _print("no attempt, cluster", parents["cluster"])
    # With a core of its own, the parent needs its processor time only; the wall time also contains its waits for the
    # disk and for the other processes of this machine.
    columns = [f"{kind}, {limit}" for kind in parents for limit in ("parent's own core", "as measured")]
    rows = []
    for workers in WORKERS:
        limits = [limit for cost in parents.values() for limit in (cost.parent, cost.wall / cost.attempts)]
        cells = [f"{projected(workers, attempt, limit):.0f}" for limit in limits]
        rows.append((f"{workers} workers", *cells))
    print()
    print(markdown_table(("attempts a minute", *columns), rows))


if __name__ == "__main__":
    run_script(main)
