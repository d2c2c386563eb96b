"""Trials side by side in worker processes; results come back to the one process that writes them down."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from types import TracebackType
from typing import Generic, Self, TypeVar

from ..exceptions import SimulationError
from ..study.worker_pool import follow_the_parent

Task = TypeVar("Task")
Report = TypeVar("Report")

_ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


class TrialPool(Generic[Task, Report]):
    """A function and the processes that it runs in; with one job it runs in this process.

    Use it as a context: leaving it by an error or an interrupt ends the workers at once.
    """

    def __init__(self, function: Callable[[Task], Report], jobs: int) -> None:
        """Take a function of a module's top level; workers start with the first work.

        Args:
            function: from a task to a report; both must be picklable.
            jobs: number of processes, at least 1.
        """
        self._function, self._jobs = function, jobs
        self._pool: ProcessPoolExecutor | None = None

    def __enter__(self) -> Self:
        """Begin."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the workers."""
        if self._pool is None:
            return
        if kind is not None:
            for process in list(getattr(self._pool, "_processes", {}).values()):
                process.terminate()
        self._pool.shutdown(wait=True, cancel_futures=True)

    def results(self, tasks: Sequence[Task]) -> Iterator[Report]:
        """Yield a report for every task, as they get ready.

        Raises:
            SimulationError: where a worker died, for example for want of memory.
        """
        if self._jobs == 1 or not tasks:
            yield from map(self._function, tasks)
            return
        if self._pool is None:
            # Each worker is busy by itself; threads of a linear algebra library would only get into their way.
            for name in _ONE_THREAD:
                os.environ.setdefault(name, "1")
            context = multiprocessing.get_context("spawn")
            self._pool = ProcessPoolExecutor(self._jobs, context, initializer=_serve_the_parent)
        futures = [self._pool.submit(self._function, task) for task in tasks]
        try:
            for future in as_completed(futures):
                yield future.result()
        except BrokenProcessPool:
            raise SimulationError(
                "a worker process died, perhaps for want of memory; what was finished is kept, so run the same command "
                "again with fewer --jobs"
            ) from None


def _serve_the_parent() -> None:
    """Leave interrupts to the parent, and end where it has ended."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    follow_the_parent()
