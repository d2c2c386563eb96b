"""The state of this machine's processes, from Linux's /proc."""

import contextlib
import time
from pathlib import Path


def is_there(process):
    """Return whether a process runs; one that has ended does not, even while its parent has not collected it."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def wait_until_gone(processes):
    """Wait for the end of processes."""
    for _ in range(600):
        if not any(map(is_there, processes)):
            return
        time.sleep(0.1)
    raise AssertionError(f"{[process for process in processes if is_there(process)]} are still there")


def children(process):
    """Return the numbers of the processes that a `Popen` has started."""
    statuses = {}
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            statuses[int(folder.name)] = (folder / "stat").read_text()
    parents = {child: int(status.rpartition(")")[2].split()[1]) for child, status in statuses.items()}
    return [child for child, parent in parents.items() if parent == process.pid]
