"""Hands work items to a pool and yields results, for this process, worker processes and a cluster alike."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from queue import Empty, SimpleQueue
from types import TracebackType
from typing import Any, Protocol, Self, TypeVar

from ..exceptions import SimulationError

_LOGGER = logging.getLogger(__name__)

Item = TypeVar("Item")
Result = TypeVar("Result")


class Pool(Protocol):
    """Workers that run a function on work items."""

    retries: int
    """How often a work item is repeated after its worker died."""

    def width(self) -> int:
        """Return how many work items may be under way."""

    def submit(self, function: Callable[[Any], Any], item: Any) -> Future[Any]:
        """Hand a work item to a worker."""

    def died(self, error: BaseException) -> bool:
        """Return whether an error means that the worker died, rather than that the function raised."""


class InlinePool:
    """A pool without workers: it runs each work item in this process, at the moment of `submit`."""

    retries = 0

    def __enter__(self) -> Self:
        """Return the pool."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Do nothing; this pool holds no workers."""

    def width(self) -> int:
        """Return 1: the process does one thing at a time."""
        return 1

    def submit(self, function: Callable[[Any], Any], item: Any) -> Future[Any]:
        """Run a work item; an interrupt passes through at once."""
        future: Future[Any] = Future()
        try:
            future.set_result(function(item))
        except Exception as error:
            future.set_exception(error)
        return future

    def died(self, error: BaseException) -> bool:
        """Return False: what this process raises is an error of the function."""
        return False


def dispatch(
    pool: Pool,
    function: Callable[[Item], Result],
    work_items: Sequence[Item],
    worker_died: Callable[[Item, int], Result],
) -> Iterator[list[tuple[Item, Result]]]:
    """Yield work items with their results; those that are ready at the same time come together.

    Args:
        pool: Pool of workers.
        function: Function of a module's top level, from a work item to a result.
        work_items: Work items, in the order in which they are handed out.
        worker_died: Function from a work item and the number of workers that died with it to its result. It is called
            when the pool's retries are used up.

    Raises:
        SimulationError: The scheduler of a cluster was lost, or the memory is too small.
        PilegraspError: The function raised. Every other work item would fail too, so the dispatch ends.
    """
    waiting = deque((item, 0) for item in work_items)
    running: dict[Future[Result], tuple[Item, int]] = {}
    ready: SimpleQueue[Future[Result]] = SimpleQueue()
    while waiting or running:
        while waiting and len(running) < pool.width():
            item, deaths = waiting.popleft()
            future = pool.submit(function, item)
            running[future] = (item, deaths)
            future.add_done_callback(ready.put)
        batch = []
        for future in _drain(ready):
            item, deaths = running.pop(future)
            if future.cancelled():
                raise SimulationError(
                    "the scheduler was lost; finished work is kept; run the same command again for the rest"
                )
            error = future.exception()
            if error is None:
                batch.append((item, future.result()))
            elif not pool.died(error):
                raise error
            elif deaths < pool.retries:
                _LOGGER.info("a worker died; its work is done again: %s", error)
                waiting.appendleft((item, deaths + 1))
            elif isinstance(error, MemoryError):
                raise SimulationError(
                    "the memory is too small for this work, which is no result of it; finished work is kept; run the "
                    "same command again with fewer workers"
                ) from error
            else:
                batch.append((item, worker_died(item, deaths + 1)))
        if batch:
            yield batch


def _drain(ready: SimpleQueue[Any]) -> Iterator[Any]:
    """Yield the entries of the queue; wait for the first."""
    yield ready.get()
    while True:
        try:
            yield ready.get_nowait()
        except Empty:
            return
