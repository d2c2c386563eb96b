"""Workers of a dask cluster, through its `concurrent.futures` interface."""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import Future
from types import TracebackType
from typing import Any, Self

from ..exceptions import ConfigurationError

PATIENCE = 10.0
"""How long the scheduler may take to answer at first [s]."""
LOOK = 2.0
"""How often the workers are counted; they may come and go [s]."""
AHEAD = 2
"""Tasks a worker, so that it has the next one when it has finished one."""


class ClusterPool:
    """The workers of a scheduler, each with one thread."""

    retries = 0
    """The scheduler itself repeats a task whose worker died, `distributed.scheduler.allowed-failures` times."""

    def __init__(self, address: str) -> None:
        """Connect to a scheduler.

        Raises:
            ConfigurationError: where `distributed` is not installed or nobody answers.
        """
        try:
            from distributed import Client
        except ImportError:
            raise ConfigurationError(
                "--scheduler needs the package distributed; install it with `pip install 'pilegrasp[cluster]'`"
            ) from None
        try:
            self._client = Client(address, timeout=PATIENCE, set_as_default=False)
        except (OSError, TimeoutError, ValueError, TypeError) as error:
            raise ConfigurationError(
                f"no scheduler answers at {address!r} ({error}); start one with `dask scheduler` and give its address, "
                "as in tcp://10.0.0.1:8786"
            ) from None
        self._executor = self._client.get_executor(pure=False)
        self._width, self._looked = 1, -LOOK

    def __enter__(self) -> Self:
        """Begin."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Give back what is under way, and leave the cluster as it is."""
        self._executor.shutdown(wait=False)
        self._client.close()

    def width(self) -> int:
        """Return how many tasks may be under way: some for every worker that is there now.

        Raises:
            ConfigurationError: where a worker has several threads, which would share one interpreter.
        """
        if time.monotonic() - self._looked >= LOOK:
            threads = self._client.nthreads()
            for worker, count in threads.items():
                if count != 1:
                    raise ConfigurationError(
                        f"the worker {worker} has {count} threads, which would wait for one another; start workers "
                        "with `--nthreads 1`, one for each core"
                    )
            self._width, self._looked = max(1, AHEAD * len(threads)), time.monotonic()
        return self._width

    def submit(self, function: Callable[[Any], Any], task: Any) -> Future[Any]:
        """Hand a task to the scheduler."""
        return self._executor.submit(function, task)

    def died(self, error: BaseException) -> bool:
        """Return whether an error of a future means that workers ran out of memory or died."""
        from distributed.scheduler import KilledWorker

        return isinstance(error, KilledWorker | MemoryError)
