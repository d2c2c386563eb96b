"""Pages and pictures that this program wrote on this machine, recognised by a digest that lies in the user's cache.

A folder of a study may come from a stranger, and a page in it may run any script. So a page is linked, kept or drawn
only if this machine wrote it, byte by byte. Every other page is made again.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

from ..exceptions import PilegraspError
from ..files import cache_folder, read_file

MAX_SIZE = 1 << 30
"""Largest file that is compared [bytes], chosen: that of the largest recording. A larger one counts as foreign."""


def is_own(file: Path, *sources: Path | str) -> bool:
    """Return whether a file is as `note_own` knew it, and so are its sources.

    Args:
        file: Page or picture, anywhere.
        sources: Files from which it was made, or texts that say of what it is the page.
    """
    try:
        return _mark(file, *sources).is_file()
    except (PilegraspError, OSError):
        return False


def note_own(file: Path, *sources: Path | str) -> None:
    """Remember a file that was just written. If the cache cannot be written, it will be made anew another time."""
    try:
        mark = _mark(file, *sources)
        mark.parent.mkdir(parents=True, exist_ok=True)
        mark.touch()
    except (PilegraspError, OSError):
        return


def _mark(file: Path, *sources: Path | str) -> Path:
    total = hashlib.sha256()
    for part in (file, *sources):
        content = part.encode("utf-8", errors="surrogateescape") if isinstance(part, str) else _content(part)
        total.update(hashlib.sha256(content).digest())
    return cache_folder() / "pilegrasp" / "pages" / total.hexdigest()


def _content(file: Path) -> bytes:
    return read_file(file, MAX_SIZE)
