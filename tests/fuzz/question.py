"""A question to the program: files that are laid out, and what is called; and the answer, as seen from outside."""

from __future__ import annotations

import base64
import json
import os
import socket
import stat
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

SPECIAL = ("fifo", "folder", "link to itself", "link to /dev/zero", "socket", "unreadable", "40 MB")
"""Things in the place of a file that are no file to read, or a very large one."""

WORK, TEMPORARY, HOME = "work", "tmp", "home"
"""Folders of a question: where the program runs, its temporary folder, and its home."""


@dataclass(frozen=True, slots=True)
class Question:
    """What is asked.

    Attributes:
        kind: Kind of the input, for the table.
        call: Arguments of `pilegrasp`; or a function of `calls.py` as "@name", and its arguments.
        files: Contents by path relative to the folder of work, or one of `SPECIAL`. A path that begins with "~/" lies
            in the home folder.
        writes: Beginnings of the paths in the folder of work that the call may leave there, also after an error.
        patience: Longest time that the answer may take [s].
        stop_after: Control periods after which an attempt is ended, because its input has been accepted; None: never.
    """

    kind: str
    call: tuple[str, ...]
    files: Mapping[str, bytes | str] = field(default_factory=dict)
    writes: tuple[str, ...] = ()
    stop_after: int | None = 100
    patience: float = 120.0

    def lay(self, folder: Path) -> None:
        """Make the folders and files of the question."""
        for name in (WORK, TEMPORARY, HOME):
            (folder / name).mkdir(parents=True)
        for name, content in self.files.items():
            path = folder / HOME / name[2:] if name.startswith("~/") else folder / WORK / name
            path.parent.mkdir(parents=True, exist_ok=True)
            if isinstance(content, bytes):
                path.write_bytes(content)
            else:
                _lay_special(path, content)

    def to_json(self) -> str:
        """Return the question as text, for the corpus."""
        files = {
            name: content if isinstance(content, str) else {"base64": base64.b64encode(content).decode()}
            for name, content in self.files.items()
        }
        table = {"kind": self.kind, "call": self.call, "files": files, "writes": self.writes}
        table |= {"stop_after": self.stop_after, "patience": self.patience}
        return json.dumps(table, indent=1) + "\n"

    @classmethod
    def from_json(cls, text: str) -> Question:
        """Read what `to_json` wrote."""
        table = json.loads(text)
        files = {
            name: content if isinstance(content, str) else base64.b64decode(content["base64"])
            for name, content in table["files"].items()
        }
        table |= {"call": tuple(table["call"]), "files": files, "writes": tuple(table["writes"])}
        return cls(**table)


def _lay_special(path: Path, what: str) -> None:
    match what:
        case "fifo":
            os.mkfifo(path)
        case "folder":
            path.mkdir()
        case "link to itself":
            path.symlink_to(path.name)
        case "link to /dev/zero":
            path.symlink_to("/dev/zero")
        case "socket":
            here = os.getcwd()
            os.chdir(path.parent)  # the path of a socket may have 107 letters only
            with socket.socket(socket.AF_UNIX) as made:
                made.bind(path.name)
            os.chdir(here)
        case "unreadable":
            path.write_bytes(b"")
            path.chmod(0)
        case "40 MB":
            path.write_bytes(b"a = 1 # and so on\n" * (40 << 20 >> 4))
        case _:
            raise AssertionError(what)


@dataclass(frozen=True, slots=True)
class Answer:
    """What came back.

    Attributes:
        status: Exit status; minus the number of a signal that ended the process; None if it had to be ended.
        out: Standard output.
        err: Standard error.
        accepted: Whether the attempt had begun when it was ended on purpose.
        wall: Time on the wall clock [s].
        processor: Processor time [s].
        memory: Largest resident memory above that of the waiting process [bytes].
        changed: Paths in the folder of work that appeared, vanished or changed.
        left: Paths that were left in the temporary folder, or are parts of files.
    """

    status: int | None
    out: str
    err: str
    accepted: bool
    wall: float
    processor: float
    memory: int
    changed: tuple[str, ...]
    left: tuple[str, ...]


def snapshot(folder: Path) -> dict[str, Any]:
    """Return what each path below a folder is: its type, size, and time of change."""
    found: dict[str, Any] = {}
    for place, folders, files in os.walk(folder):
        for name in (*folders, *files):
            path = Path(place) / name
            about = path.lstat()
            regular = stat.S_ISREG(about.st_mode)
            found[str(path.relative_to(folder))] = (
                stat.S_IFMT(about.st_mode),
                *((about.st_size, about.st_mtime_ns) if regular else ()),
            )
    return found
