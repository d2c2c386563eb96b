"""Python warnings that are ignored in one thread only."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress


class _QuietThreads(threading.local):
    """Matches every module in a thread that asked for quiet, and none in the others."""

    quiet = False

    def match(self, module: str) -> bool:
        """Stand in for the compiled pattern of a warning filter."""
        return self.quiet


_QUIET = _QuietThreads()
_FILTER = ("ignore", None, Warning, _QUIET, 0)


@contextmanager
def without_warnings() -> Iterator[None]:
    """Ignore warnings in this thread.

    `warnings.catch_warnings` replaces the filters of all threads, and loses what another thread changes meanwhile. This
    adds one filter that acts only in threads that asked for it.
    """
    filters = warnings.filters
    if not filters or filters[0] is not _FILTER:
        with suppress(ValueError):
            filters.remove(_FILTER)  # type: ignore[attr-defined]
        filters.insert(0, _FILTER)  # type: ignore[attr-defined, arg-type]
    before, _QUIET.quiet = _QUIET.quiet, True
    try:
        yield
    finally:
        _QUIET.quiet = before
