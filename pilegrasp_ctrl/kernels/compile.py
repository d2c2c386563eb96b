"""How a kernel is compiled: at import, for exactly the types that its signature states.

A kernel uses only loops, `+ - * /` and `math.*`. Its compiled and its plain form then give the same bits on every
processor. It does not use `@`, `np.dot`, `np.linalg`, `.sum()`, `**` or numpy's transcendental functions. With
`NUMBA_DISABLE_JIT=1` kernels run as plain Python.
"""

from __future__ import annotations

import logging
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

import numba
from numba import types

VECTOR = types.Array(types.float64, 1, "A", readonly=True)
"""Type of an input vector."""
MATRIX = types.Array(types.float64, 2, "A", readonly=True)
"""Type of an input matrix."""
OUT_VECTOR = types.Array(types.float64, 1, "C")
"""Type of a vector to fill."""
OUT_MATRIX = types.Array(types.float64, 2, "C")
"""Type of a matrix to fill."""
OUT_MATRICES = types.Array(types.float64, 3, "C")
"""Type of a stack of matrices to fill."""
INDICES = types.Array(types.int64, 1, "C")
"""Type of a vector of indices, to read or to fill."""
NUMBER = types.float64
"""Type of a number."""
COUNT = types.int64
"""Type of a whole number."""
FLAG = types.boolean
"""Type of an answer of yes or no."""
NOTHING = types.void
"""Type of no answer."""

Kernel = Callable[..., Any]
"""Type of a kernel."""


def kernel(answer: Any, *arguments: Any) -> Callable[[Kernel], Kernel]:
    """Return the decorator that compiles a function with these types of answer and arguments.

    A new type in the middle of a motion would stop it for seconds; with stated types it is an error at once. Shapes
    are not checked: the caller sees to them.
    """
    signature = answer(*arguments)

    def decorate(function: Kernel) -> Kernel:
        for attempt in range(2):
            try:
                with _cached():
                    compiled: Kernel = numba.njit([signature], cache=True, error_model="numpy")(function)
                return compiled
            except Exception:
                # A damaged file ends every start that reads it: the cache is made anew. If that does not help, no
                # folder is writable, or the kernel itself is wrong, which the uncached compilation says.
                if attempt == 0:
                    shutil.rmtree(_cache_folder(), ignore_errors=True)
        uncached: Kernel = numba.njit([signature], error_model="numpy")(function)
        return uncached

    return decorate


@contextmanager
def _cached() -> Iterator[None]:
    """Let numba cache in the project's folder."""
    configured, numba.config.CACHE_DIR = numba.config.CACHE_DIR, str(_cache_folder())
    try:
        yield
    finally:
        numba.config.CACHE_DIR = configured


@cache
def _cache_folder() -> Path:
    """Return the folder of the compiled code: beside the kernels if that is writable, otherwise in the user's cache.

    It is named by a digest of all kernels, because numba does not notice when a kernel that another one calls has
    changed.
    """
    here = Path(__file__).parent
    digest = sha256(numba.__version__.encode())
    for file in sorted(here.glob("*.py")):
        digest.update(file.read_bytes())
    name = f"kernels-{digest.hexdigest()[:16]}"
    for parent in (here / "__pycache__", Path.home() / ".cache" / "pilegrasp"):
        folder = parent / name
        if folder.is_dir():
            return folder
        try:
            folder.mkdir(parents=True)
        except OSError:
            continue
        if not numba.config.DISABLE_JIT:
            logging.getLogger(__name__).warning(
                "pilegrasp compiles its control law for this machine, once: up to a minute"
            )
        return folder
    return here / "__pycache__" / name
