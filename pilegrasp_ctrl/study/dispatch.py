"""Tasks out, results in: the same for processes of this machine and for those of a cluster."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from queue import Empty, SimpleQueue
from typing import Any, Protocol, TypeVar

from ..exceptions import SimulationError

Task = TypeVar("Task")
Result = TypeVar("Result")


class Pool(Protocol):
    """Where tasks are carried out."""

    retries: int

    def width(self) -> int:
        """Return how many tasks may be under way."""

    def submit(self, function: Callable[[Any], Any], task: Any) -> Future[Any]:
        """Hand a task out."""

    def died(self, error: BaseException) -> bool:
        """Return whether an error means that the worker died, rather than that the task raised."""


def dispatch(
    pool: Pool, function: Callable[[Task], Result], tasks: Sequence[Task], died: Callable[[Task, int], Result]
) -> Iterator[list[tuple[Task, Result]]]:
    """Yield tasks with their results as they get ready, all that are ready together.

    Args:
        pool: of workers.
        function: from a task to a result, of a module's top level; it returns what the task raises.
        tasks: in the order in which they are handed out.
        died: the result of a task with which so many workers died.

    Raises:
        PilegraspError: what the function raises nevertheless, because no other task would fare better.
    """
    waiting = deque((task, 0) for task in tasks)
    running: dict[Future[Result], tuple[Task, int]] = {}
    ready: SimpleQueue[Future[Result]] = SimpleQueue()
    while waiting or running:
        while waiting and len(running) < pool.width():
            task, deaths = waiting.popleft()
            future = pool.submit(function, task)
            running[future] = (task, deaths)
            future.add_done_callback(ready.put)
        batch = []
        for future in _all(ready):
            task, deaths = running.pop(future)
            if future.cancelled():
                raise SimulationError(
                    "the scheduler was lost; what is finished is kept, and the same command does the rest"
                )
            error = future.exception()
            if error is None:
                batch.append((task, future.result()))
            elif not pool.died(error):
                raise error
            elif deaths < pool.retries:
                waiting.appendleft((task, deaths + 1))
            else:
                batch.append((task, died(task, deaths + 1)))
        if batch:
            yield batch


def _all(ready: SimpleQueue[Any]) -> Iterator[Any]:
    """Yield what is in the queue; wait for the first."""
    yield ready.get()
    while True:
        try:
            yield ready.get_nowait()
        except Empty:
            return
