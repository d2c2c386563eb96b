"""Clocks of the benchmark: pieces of work take turns, so that other programs disturb all of them alike."""

from __future__ import annotations

import gc
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from time import perf_counter
from typing import NamedTuple

import numpy as np

from ...programs.quiet_loop import no_garbage_collection
from ...types import Array

WARM_UP = 20
"""Calls of each piece of work before its first block [-]; chosen."""

LEAD_IN = 5
"""Calls at the start of each block that do not count [-], because the caches hold another piece of work; chosen."""

MIN_CALLS = 5
"""Smallest number of calls in a block of a slow piece of work [-]; chosen."""

STATEMENTS = {
    "python": "pass",
    "import numpy": "import numpy",
    "import pinocchio": "import pinocchio",
    "import mujoco": "import mujoco",
    "import pilegrasp_ctrl": "import pilegrasp_ctrl",
    "pilegrasp list": "from pilegrasp_ctrl.cli import main; main(['list'])",
    "first controller": "import pilegrasp_ctrl as pg; pg.OperationalSpaceController(pg.ArmModel.load('wam7'))",
    "import mink": "import mink",
}
"""Statements that are timed in fresh interpreters; the time of the first is part of all others."""


class Timing(NamedTuple):
    """The durations of one piece of work.

    Attributes:
        calls: Number of calls that were timed.
        median: Median [s].
        p99: 99th percentile [s].
        worst: Longest call [s].
        blocks: Median of each block [s]; their spread is the machine's noise.
        tail: Ratio of p99 to median within a block, the median over the blocks. A block is about as long as the time
            slice that the system gives to another program, so one interruption does not change the median.
    """

    calls: int
    median: float
    p99: float
    worst: float
    blocks: tuple[float, ...]
    tail: float

    @classmethod
    def of(cls, blocks: Sequence[Array]) -> Timing:
        """Return the statistics of the durations (n,) [s] of every block."""
        every = np.concatenate(blocks)
        median, p99 = np.percentile(every, [50.0, 99.0]).tolist()
        inside = np.array([np.percentile(block, [50.0, 99.0]) for block in blocks])
        tail = float(np.median(inside[:, 1] / inside[:, 0]))
        return cls(len(every), median, p99, float(every.max()), tuple(inside[:, 0].tolist()), tail)


class Work(NamedTuple):
    """A piece of work that can be repeated.

    Attributes:
        key: Name in the result.
        call: Function that does the work once; its argument counts up from 0.
    """

    key: str
    call: Callable[[int], object]


@contextmanager
def garbage_kept() -> Iterator[None]:
    """Keep the garbage collector out of the measurements, as the closed loop does; collect before and after."""
    gc.collect()
    with no_garbage_collection():
        yield
    gc.collect()


def time_in_turns(
    works: Sequence[Work], blocks: int, block_time: float, block_done: Callable[[], None] = lambda: None
) -> dict[str, Timing]:
    """Time every piece of work in `blocks` blocks of about `block_time` [s], one block of each in turn.

    Compare only timings of one call of this function.

    Args:
        works: Pieces of work; their keys differ.
        blocks: Number of blocks of each.
        block_time: Time that a block of each should take [s].
        block_done: Function that is called after each round of blocks.
    """
    calls = {work.key: _calls(work, block_time) for work in works}
    durations: dict[str, list[Array]] = {work.key: [] for work in works}
    done = dict.fromkeys(calls, 0)
    for _ in range(blocks):
        for key, call in works:
            first = done[key]
            done[key] += calls[key]
            durations[key].append(_block(call, range(first, done[key])))
        block_done()
    return {key: Timing.of(parts) for key, parts in durations.items()}


def _calls(work: Work, block_time: float) -> int:
    """Return how many calls fill a block, and warm the work up."""
    once = float(np.median(_block(work.call, range(WARM_UP))))
    return max(MIN_CALLS, int(block_time / once))


def _block(call: Callable[[int], object], indices: range) -> Array:
    for index in range(indices.start, indices.start + LEAD_IN):
        call(index)
    durations = np.empty(len(indices))
    for position, index in enumerate(indices):
        start = perf_counter()
        call(index)
        durations[position] = perf_counter() - start
    return durations


def time_imports(rounds: int, round_done: Callable[[], None] = lambda: None) -> dict[str, Timing]:
    """Start a fresh interpreter for each of `STATEMENTS`, `rounds` times in turns.

    One more round comes first and does not count; it fills the file system's cache.

    Args:
        rounds: Number of rounds that count, at least 1.
        round_done: Function that is called after each round, the first included.
    """
    durations: dict[str, list[float]] = {key: [] for key in STATEMENTS}
    for _ in range(1 + rounds):
        for key, statement in STATEMENTS.items():
            start = perf_counter()
            subprocess.run([sys.executable, "-c", statement], check=True, stdout=subprocess.DEVNULL)
            durations[key].append(perf_counter() - start)
        round_done()
    return {key: Timing.of([np.array([value]) for value in values[1:]]) for key, values in durations.items()}
