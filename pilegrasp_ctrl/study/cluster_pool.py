"""Workers of a dask cluster. Whatever the other side does, or does not do, this side answers in time."""

from __future__ import annotations

import asyncio
import concurrent.futures
import contextlib
import logging
import socket
import threading
import time
from collections.abc import Callable, Coroutine
from concurrent.futures import Future
from types import TracebackType
from typing import Any, Self

from ..exceptions import ConfigurationError
from .scheduler import Scheduler

CONNECT_TIMEOUT = 8.0
"""How long the scheduler may take until the connection stands, certificates and greetings included [s] (chosen)."""
CLOSE_TIMEOUT = 2.0
"""How long a connection may take to close [s] (chosen); then it is left."""
WATCH_PERIOD = 2.0
"""How often the workers are counted [s] (chosen). They may come and go."""
ANSWER_TIMEOUT = 10.0
"""How long the scheduler may take to count its workers [s] (chosen). One that takes longer is lost."""
ITEMS_PER_WORKER = 2
"""Work items that are under way for each worker, so that the next one is there when the first is finished."""


class ClusterPool:
    """The workers of a dask scheduler, each with one thread.

    dask waits in several places without a limit for what a scheduler says. Its client therefore runs in a thread of its
    own, and this side waits for that thread as long as it wants to.
    """

    retries = 0
    """The scheduler repeats an item whose worker died, `distributed.scheduler.allowed-failures` times."""

    def __init__(self, scheduler: Scheduler | str) -> None:
        """Connect to a scheduler.

        Raises:
            ConfigurationError: `distributed` is not installed, the address or a certificate cannot be used, or no
                scheduler answers.
        """
        scheduler = scheduler if isinstance(scheduler, Scheduler) else Scheduler(scheduler)
        try:
            import distributed  # noqa: F401
        except ImportError:
            raise ConfigurationError(
                "--scheduler needs the package distributed; install it with `pip install 'pilegrasp[cluster]'`"
            ) from None
        arguments = scheduler.connection_arguments()
        _silence_dask()
        self._threads: dict[str, int] = {}
        self._running: set[Future[Any]] = set()
        self._closing = False
        self._loop = asyncio.new_event_loop()
        self._loop.set_exception_handler(lambda loop, context: None)
        threading.Thread(target=self._loop.run_forever, daemon=True, name="dask client").start()
        try:
            deadline = time.monotonic() + CONNECT_TIMEOUT
            _resolve(scheduler.host, scheduler.port, CONNECT_TIMEOUT)
            self._client = self._wait_for(_connect(scheduler.address, arguments), deadline - time.monotonic())
        # What a stranger's answer does to dask has many types, among them MemoryError and AssertionError.
        except Exception as error:
            self._loop.call_soon_threadsafe(self._loop.stop)
            raise ConfigurationError(
                f"no scheduler answers at {scheduler.address!r:.80} ({_reason(error)}); start one with "
                "`dask scheduler` and give its address, as in tcp://127.0.0.1:8786"
            ) from None
        self._watch = asyncio.run_coroutine_threadsafe(self._count_workers(), self._loop)

    def __enter__(self) -> Self:
        """Return the pool."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Cancel the work items under way, and leave the cluster running."""
        self._closing = True
        self._watch.cancel()
        with contextlib.suppress(Exception):
            self._wait_for(self._client.close(CLOSE_TIMEOUT), CLOSE_TIMEOUT)
        self._loop.call_soon_threadsafe(self._loop.stop)

    def width(self) -> int:
        """Return how many work items may be under way: some for every worker that was there at the last count.

        Raises:
            ConfigurationError: A worker has several threads, which would share one interpreter.
        """
        threads = dict(self._threads)
        for worker, count in threads.items():
            if count != 1:
                raise ConfigurationError(
                    f"the worker {worker} has {count} threads, which would wait for one another; start workers "
                    "with `--nthreads 1`, one for each core"
                )
        return max(1, ITEMS_PER_WORKER * len(threads))

    def submit(self, function: Callable[[Any], Any], item: Any) -> Future[Any]:
        """Hand a work item to the scheduler."""
        future = asyncio.run_coroutine_threadsafe(self._result(function, item), self._loop)
        self._running.add(future)
        future.add_done_callback(self._running.discard)
        return future

    def died(self, error: BaseException) -> bool:
        """Return whether an error of a future means that workers died or ran out of memory."""
        from distributed.scheduler import KilledWorker

        return isinstance(error, KilledWorker | MemoryError)

    def _wait_for(self, answer: Coroutine[Any, Any, Any], timeout: float) -> Any:
        """Wait for a coroutine of the client's thread.

        Raises:
            TimeoutError: It takes longer.
        """
        future = asyncio.run_coroutine_threadsafe(answer, self._loop)
        try:
            return future.result(max(timeout, 0.0))
        except TimeoutError:
            future.cancel()
            raise

    async def _result(self, function: Callable[[Any], Any], item: Any) -> Any:
        from distributed.comm import CommClosedError

        try:
            return await self._client.submit(function, item, pure=False)
        # So dask says that the scheduler was lost; only asyncio's own type cancels a future.
        except (concurrent.futures.CancelledError, CommClosedError):
            raise asyncio.CancelledError from None

    async def _count_workers(self) -> None:
        """Count the workers now and then; if the scheduler does not answer, cancel what is under way."""
        while True:
            try:
                self._threads = dict(await asyncio.wait_for(self._client.nthreads(), ANSWER_TIMEOUT))
            except (Exception, asyncio.CancelledError):
                # dask cancels what it waits for when it loses a connection; this watch must outlive that.
                if self._closing:
                    raise
                for future in list(self._running):
                    future.cancel()
            await asyncio.sleep(WATCH_PERIOD)


def _silence_dask() -> None:
    """Keep dask's log off standard error; what it reports as an error is one sentence here."""
    for name in list(logging.root.manager.loggerDict):
        if name.partition(".")[0] == "distributed":
            logging.getLogger(name).setLevel(logging.CRITICAL)


async def _connect(address: str, arguments: dict[str, Any]) -> Any:
    """Return a client that is connected.

    Raises:
        Exception: The other side is no scheduler.
    """
    from distributed import Client

    # dask retries for so long, and then names the reason; it must do so before the patience of this side ends.
    patience = 0.8 * CONNECT_TIMEOUT
    client = Client(address, asynchronous=True, timeout=patience, set_as_default=False, **arguments)
    try:
        await asyncio.wait_for(client, CONNECT_TIMEOUT)
    except BaseException:
        with contextlib.suppress(Exception):
            await asyncio.wait_for(client.close(CLOSE_TIMEOUT), CLOSE_TIMEOUT)
        raise
    return client


def _resolve(host: str, port: int, timeout: float) -> None:
    """Look a machine's name up; a name server that does not answer keeps only a thread that ends with the process.

    Raises:
        OSError: The name is not known, or the name server does not answer in time.
    """
    found: Future[Any] = Future()

    def look_up() -> None:
        try:
            found.set_result(socket.getaddrinfo(host, port, type=socket.SOCK_STREAM))
        except Exception as error:
            found.set_exception(error)

    threading.Thread(target=look_up, daemon=True, name="name server").start()
    try:
        found.result(timeout)
    except concurrent.futures.TimeoutError:
        raise OSError(f"the name {host!r:.80} was not found in {timeout:g} s") from None
    except UnicodeError:
        raise OSError(f"{host!r:.80} is not the name of a machine") from None


def _reason(error: BaseException) -> str:
    """Return why there is no connection, in short."""
    if isinstance(error, TimeoutError | asyncio.TimeoutError):
        return f"it did not greet within {CONNECT_TIMEOUT:g} s"
    while isinstance(error, OSError) and isinstance(error.__cause__, OSError):
        error = error.__cause__
    if isinstance(error, OSError):
        return " ".join(f"{error.strerror or error}".split())[:120]
    return "something answers there that is not a scheduler"
