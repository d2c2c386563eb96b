"""Clocks of the benchmark: pieces of work are timed in turns, so that the machine's moods meet all of them alike."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from time import perf_counter
from typing import NamedTuple

import numpy as np

from ...types import Array

WARM_UP = 20
"""Calls of each piece of work before the first block counts."""

LEAD_IN = 5
"""Calls at the start of each block that do not count: they find the caches full of another piece of work."""

FEWEST_CALLS = 5
"""A block of a slow piece of work counts at least this many calls."""


class Timing(NamedTuple):
    """How long one piece of work took.

    Attributes:
        calls: how many were timed.
        median: [s].
        p99: 99th percentile [s].
        worst: [s].
        blocks: the median of each block [s]; their spread is the machine's noise.
        tail: p99 over median within a block, the median over the blocks. A block is about as long as the slice of time
            for which the system hands the processor to another program, so that one such break does not count.
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
        key: its name in the result.
        call: does it once; the argument counts up from 0.
    """

    key: str
    call: Callable[[int], object]


@contextmanager
def garbage_kept() -> Iterator[None]:
    """Keep the collector out of the measurements, as the closed loop does; collect before and after."""
    enabled = gc.isenabled()
    gc.collect()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()
        gc.collect()


def time_in_turns(
    works: Sequence[Work], blocks: int, block_time: float, block_done: Callable[[], None] = lambda: None
) -> dict[str, Timing]:
    """Time every piece of work in `blocks` blocks of about `block_time` [s], one block of each in turn.

    Only what is compared within one run of this function deserves to be compared.

    Args:
        works: what to time; keys differ.
        blocks: number of blocks of each.
        block_time: what a block of each should take [s].
        block_done: called after each round of blocks.
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
    return max(FEWEST_CALLS, int(block_time / once))


def _block(call: Callable[[int], object], indices: range) -> Array:
    for index in range(indices.start, indices.start + LEAD_IN):
        call(index)
    durations = np.empty(len(indices))
    for position, index in enumerate(indices):
        start = perf_counter()
        call(index)
        durations[position] = perf_counter() - start
    return durations
