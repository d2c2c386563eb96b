"""Workers of a dask cluster, through its `concurrent.futures` interface."""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import Future
from types import TracebackType
from typing import Any, Self

from ..exceptions import ConfigurationError

CONNECT_TIMEOUT = 10.0
"""How long the scheduler may take to answer the connection [s] (chosen)."""
COUNT_PERIOD = 2.0
"""How often the workers are counted [s] (chosen); they may come and go."""
ITEMS_PER_WORKER = 2
"""Work items that are under way for each worker, so that the next one is there when the first is finished."""


class ClusterPool:
    """The workers of a dask scheduler, each with one thread."""

    retries = 0
    """The scheduler repeats an item whose worker died, `distributed.scheduler.allowed-failures` times."""

    def __init__(self, address: str) -> None:
        """Connect to a scheduler.

        Raises:
            ConfigurationError: `distributed` is not installed, or no scheduler answers.
        """
        try:
            from distributed import Client
        except ImportError:
            raise ConfigurationError(
                "--scheduler needs the package distributed; install it with `pip install 'pilegrasp[cluster]'`"
            ) from None
        try:
            self._client = Client(address, timeout=CONNECT_TIMEOUT, set_as_default=False)
        except (OSError, TimeoutError, ValueError, TypeError) as error:
            raise ConfigurationError(
                f"no scheduler answers at {address!r} ({error}); start one with `dask scheduler` and give its address, "
                "as in tcp://10.0.0.1:8786"
            ) from None
        self._executor = self._client.get_executor(pure=False)
        self._width, self._counted = 1, -COUNT_PERIOD

    def __enter__(self) -> Self:
        """Return the pool."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Cancel the work items under way, and leave the cluster running."""
        self._executor.shutdown(wait=False)
        self._client.close()

    def width(self) -> int:
        """Return how many work items may be under way: some for every worker that is there now.

        Raises:
            ConfigurationError: A worker has several threads, which would share one interpreter.
        """
        if time.monotonic() - self._counted >= COUNT_PERIOD:
            threads = self._client.nthreads()
            for worker, count in threads.items():
                if count != 1:
                    raise ConfigurationError(
                        f"the worker {worker} has {count} threads, which would wait for one another; start workers "
                        "with `--nthreads 1`, one for each core"
                    )
            self._width, self._counted = max(1, ITEMS_PER_WORKER * len(threads)), time.monotonic()
        return self._width

    def submit(self, function: Callable[[Any], Any], item: Any) -> Future[Any]:
        """Hand a work item to the scheduler."""
        return self._executor.submit(function, item)

    def died(self, error: BaseException) -> bool:
        """Return whether an error of a future means that workers died or ran out of memory."""
        from distributed.scheduler import KilledWorker

        return isinstance(error, KilledWorker | MemoryError)
