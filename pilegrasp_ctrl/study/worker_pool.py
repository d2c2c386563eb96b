"""Worker processes on this machine, each with a separate executor, so that a dying worker leaves the others alive."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import partial
from queue import Empty, LifoQueue
from types import TracebackType
from typing import Any, Self

from ..exceptions import SimulationError

MAX_FAILED_STARTS = 3
"""How many workers in a row may end before they are ready (chosen). After that, no worker is expected to start."""
RELEASE_TIMEOUT = 60.0
"""How long the thread of a finished worker may take to give it back [s] (chosen); usually it takes microseconds."""
END_TIMEOUT = 20.0
"""How long a worker may take to end by itself [s] (chosen); then it is killed."""
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
        # The last one that worked comes first, so that processes are started only when they are needed.
        self._idle: LifoQueue[_Worker | None] = LifoQueue()
        for _ in range(jobs):
            self._idle.put(None)
        self._workers: set[_Worker] = set()
        self._failed_starts = 0

    def __enter__(self) -> Self:
        """Return the pool."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the workers."""
        workers = list(self._workers)  # a killed one leaves the set
        if kind is not None:
            for worker in workers:
                worker.kill()
        for worker in workers:
            worker.join()

    def width(self) -> int:
        """Return how many work items may be under way."""
        return self._jobs

    def submit(self, function: Callable[[Any], Any], item: Any) -> Future[Any]:
        """Hand a work item to an idle worker; one is idle while fewer than `width` items are under way.

        Raises:
            SimulationError: No worker process can be started.
        """
        while True:
            worker = self._take()
            try:
                future = worker.executor.submit(function, item)
            except BrokenProcessPool:  # it died while it was idle, or before it was ready
                self._forget(worker)
                self._check_starts()
                continue
            future.add_done_callback(partial(self._release, worker))
            return future

    def _take(self) -> _Worker:
        """Return an idle worker, or a new one.

        A future is seen to be finished a moment before its thread gives the worker back, so this waits for that.
        """
        try:
            worker = self._idle.get(timeout=RELEASE_TIMEOUT)
        except Empty:
            raise SimulationError(
                f"no worker process is free after {RELEASE_TIMEOUT:g} s; finished work is kept; run the command again"
            ) from None
        if worker is None:
            try:
                worker = _Worker()
            except OSError as error:
                self._idle.put(None)
                raise SimulationError(
                    f"a worker process cannot be started: {error.strerror or error}; run the command with fewer --jobs"
                ) from error
            self._workers.add(worker)
        return worker

    def died(self, error: BaseException) -> bool:
        """Return whether an error of a future means that the worker died or ran out of memory.

        Raises:
            SimulationError: The worker processes cannot even start.
        """
        self._check_starts()
        return isinstance(error, BrokenProcessPool | MemoryError)

    def _check_starts(self) -> None:
        if self._failed_starts >= MAX_FAILED_STARTS:
            raise SimulationError(
                'the worker processes end before they start; in a script, put the call below if __name__ == "__main__"'
                ", and leave about 300 MB of memory for each worker"
            )

    def _release(self, worker: _Worker, future: Future[Any]) -> None:
        if future.cancelled() or not isinstance(future.exception(), BrokenProcessPool):
            self._failed_starts = 0
            self._idle.put(worker)
        else:
            self._forget(worker)

    def _forget(self, worker: _Worker) -> None:
        """Let a new worker take the place of one that died."""
        self._failed_starts = 0 if worker.was_ready() else self._failed_starts + 1
        self._workers.discard(worker)
        self._idle.put(None)


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

    def kill(self) -> None:
        """Kill the process."""
        for process in list((getattr(self.executor, "_processes", None) or {}).values()):
            process.kill()

    def join(self) -> None:
        """Wait until the process, and the thread that feeds it, have ended; kill a process that does not end.

        An executor waits in the first call of `shutdown` only. A thread that is still there when Python ends may print
        a traceback about a pipe that it closes at this moment.
        """
        patience = threading.Timer(END_TIMEOUT, self.kill)
        patience.daemon = True
        patience.start()
        try:
            self.executor.shutdown(wait=True, cancel_futures=True)
        finally:
            patience.cancel()
            patience.join()


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
