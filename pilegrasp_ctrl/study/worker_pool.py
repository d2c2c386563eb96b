"""Worker processes on this machine, each with a separate executor, so that a dying worker leaves the others alive."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from types import TracebackType
from typing import Any, Self

from ..exceptions import SimulationError

MAX_FAILED_STARTS = 3
"""How many workers in a row may end before they are ready (chosen). After that, no worker is expected to start."""
_ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


class WorkerPool:
    """`jobs` processes, each started when it is first needed and again after it died.

    A `ProcessPoolExecutor` breaks as a whole when one of its workers dies; here each worker has a separate executor.
    Use the pool as a context: an error or an interrupt inside it ends the workers at once.
    """

    retries = 2
    """How often a work item is repeated after its worker died."""

    def __init__(self, jobs: int) -> None:
        """Take the number of processes, at least 1."""
        self._jobs = jobs
        self._idle: deque[_Worker | None] = deque([None] * jobs)
        self._workers: set[_Worker] = set()
        self._failed_starts = 0

    def __enter__(self) -> Self:
        """Return the pool."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the workers."""
        for worker in self._workers:
            worker.end(at_once=kind is not None)
        for worker in self._workers:
            worker.join()

    def width(self) -> int:
        """Return how many work items may be under way."""
        return self._jobs

    def submit(self, function: Callable[[Any], Any], item: Any) -> Future[Any]:
        """Hand a work item to an idle worker; one is idle while fewer than `width` items are under way."""
        worker = self._idle.pop()
        if worker is None:
            worker = _Worker()
            self._workers.add(worker)
        future = worker.executor.submit(function, item)
        future.add_done_callback(lambda finished: self._release(worker, finished))
        return future

    def died(self, error: BaseException) -> bool:
        """Return whether an error of a future means that the worker died or ran out of memory.

        Raises:
            SimulationError: The worker processes cannot even start.
        """
        if self._failed_starts >= MAX_FAILED_STARTS:
            raise SimulationError(
                'the worker processes end before they start; in a script, put the call below if __name__ == "__main__"'
                ", and leave about 300 MB of memory for each worker"
            )
        return isinstance(error, BrokenProcessPool | MemoryError)

    def _release(self, worker: _Worker, future: Future[Any]) -> None:
        if future.cancelled() or not isinstance(future.exception(), BrokenProcessPool):
            self._failed_starts = 0
            self._idle.append(worker)
            return
        self._failed_starts = 0 if worker.was_ready() else self._failed_starts + 1
        self._workers.discard(worker)
        self._idle.append(None)


class _Worker:
    """One process and the executor that feeds it."""

    def __init__(self) -> None:
        # Each worker keeps a core busy; threads of a linear algebra library would only disturb the other workers.
        for name in _ONE_THREAD:
            os.environ[name] = "1"
        context = multiprocessing.get_context("spawn")
        self.executor = ProcessPoolExecutor(1, context, initializer=_end_with_the_parent)
        with _interrupts_blocked():
            self._ready = self.executor.submit(_answer)

    def was_ready(self) -> bool:
        """Return whether the process answered once."""
        return self._ready.done() and self._ready.exception() is None

    def end(self, at_once: bool) -> None:
        """Tell the process to end after its work item, or kill it."""
        if at_once:
            for process in list(getattr(self.executor, "_processes", {}).values()):
                process.kill()
        self.executor.shutdown(wait=False, cancel_futures=True)

    def join(self) -> None:
        """Wait until the process has ended."""
        self.executor.shutdown(wait=True, cancel_futures=True)


@contextmanager
def _interrupts_blocked() -> Iterator[None]:
    """Block Ctrl-C in processes started inside: a terminal sends it to all processes; only the parent handles it."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _answer() -> None:
    """Do nothing; a result means that the process has started."""


def _end_with_the_parent() -> None:
    """End this worker when its parent ends, even if it was killed; a `ProcessPoolExecutor` alone leaves its workers."""
    threading.Thread(target=_wait_for_the_parent, daemon=True).start()


def _wait_for_the_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
