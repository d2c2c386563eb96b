"""What ties a worker process to its parent."""

from __future__ import annotations

import multiprocessing
import os
import threading


def follow_the_parent() -> None:
    """End where the parent has ended, however it did; a `ProcessPoolExecutor` by itself would leave its workers."""
    threading.Thread(target=_end_with_the_parent, daemon=True).start()


def _end_with_the_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
