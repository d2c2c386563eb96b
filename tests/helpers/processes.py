"""The state of this machine's processes, from Linux's /proc."""

import contextlib
import os
import socket
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


def members(session):
    """Return the processes of a session, by the number of its first process."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            words = (folder / "stat").read_text().rpartition(")")[2].split()
            if int(words[3]) == session:
                found.append(int(folder.name))
    return found


def children(process):
    """Return the numbers of the processes that a `Popen` has started."""
    return descendants({process.pid}, deep=False)


def descendants(processes, deep=True):
    """Return the numbers of the processes that these have started, and with `deep` of those that they have started."""
    parents = {}
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            status = (folder / "stat").read_text()
            parents[int(folder.name)] = int(status.rpartition(")")[2].split()[1])
    found, family = [], set(processes)
    while new := [child for child, parent in parents.items() if parent in family and child not in found]:
        found += new
        family = set(new) if deep else set()
    return found


def listening(process):
    """Return the addresses and ports at which a process listens, as a list of (address, port)."""
    inodes, lines = set(), []
    with contextlib.suppress(OSError):  # a process may end while it is looked at
        for descriptor in Path(f"/proc/{process}/fd").iterdir():
            with contextlib.suppress(OSError):
                inodes.add(os.readlink(descriptor))
    found = []
    for table, family in (("tcp", socket.AF_INET), ("tcp6", socket.AF_INET6)):
        with contextlib.suppress(OSError):
            lines = Path(f"/proc/{process}/net/{table}").read_text().splitlines()[1:]
        for line in lines:
            words = line.split()
            if words[3] == "0A" and f"socket:[{words[9]}]" in inodes:
                address, port = words[1].split(":")
                # The kernel prints words of four bytes in the machine's order.
                packed = b"".join(bytes.fromhex(address[i : i + 8])[::-1] for i in range(0, len(address), 8))
                found.append((socket.inet_ntop(family, packed), int(port, 16)))
    return found
