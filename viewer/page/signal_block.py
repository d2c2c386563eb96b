"""All recorded signals as one block of bytes for the page's script, which draws, zooms and reads them out."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

MAX_SAMPLES = 6000
"""Largest number of samples of a signal in a page: a minute at 100 Hz; chosen. Longer signals are thinned to the
smallest and the largest value of each of half as many bins."""

STEPS = 4095
"""Number of steps from a signal's smallest to its largest value in a page; chosen: finer than a screen."""


def signal_block(time: NDArray[np.float64], columns: Sequence[NDArray[np.float64]]) -> bytes:
    """Return S samples of C columns as bytes; nothing without samples.

    All numbers are little-endian. The block holds S and C (uint32), S times (float32), and the smallest value and the
    step of each column (float32). For each column follow the differences between its samples, counted in steps, the
    first one from zero: S low bytes, then S high bytes (of uint16, modulo 65536).
    """
    if not time.size or not columns:
        return b""
    if time.size > MAX_SAMPLES:
        time, columns = _thinned(time, columns)
    low = np.array([column.min() for column in columns])
    span = np.array([column.max() for column in columns]) - low
    step = np.where(span > 0.0, span / STEPS, 1.0)
    content = [struct.pack("<II", time.size, len(columns)), time.astype("<f4").tobytes()]
    content += [np.stack([low, step], axis=1).astype("<f4").tobytes()]
    for column, least, size in zip(columns, low, step, strict=True):
        counts = np.round((column - least) / size).astype(np.int64)
        differences = (np.diff(counts, prepend=0) & 0xFFFF).astype("<u2")
        content += [(differences & 0xFF).astype("u1").tobytes(), (differences >> 8).astype("u1").tobytes()]
    return b"".join(content)


def _thinned(
    time: NDArray[np.float64], columns: Sequence[NDArray[np.float64]]
) -> tuple[NDArray[np.float64], list[NDArray[np.float64]]]:
    """Return two samples for each bin, at its start and its middle: the extremes of a column, in their order."""
    edges = np.linspace(0, time.size, MAX_SAMPLES // 2 + 1).astype(int)
    spans = [(a, b) for a, b in pairwise(edges.tolist()) if b > a]
    times = np.array([moment for a, b in spans for moment in (time[a], 0.5 * (time[a] + time[b - 1]))])
    thin = []
    for column in columns:
        values = []
        for a, b in spans:
            piece = column[a:b]
            one, two = sorted((int(np.argmin(piece)), int(np.argmax(piece))))
            values += [piece[one], piece[two]]
        thin.append(np.array(values))
    return times, thin
