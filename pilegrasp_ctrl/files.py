"""Files that the user asked for: refused before the work starts, where they could not be written after it."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from .exceptions import ExportError

VIEWS = (".html", ".png", ".gif", ".mp4")
"""What a recording can be shown as: page, contact sheet, movies."""


def check_output(path: Path, *suffixes: str) -> None:
    """Find out whether `path` ends in one of `suffixes` and can be written, and leave nothing behind.

    Raises:
        ExportError: where the suffix is another, the folder does not exist, or the file may not be written.
    """
    if path.suffix not in suffixes:
        listed = " or ".join(filter(None, (", ".join(suffixes[:-1]), suffixes[-1])))
        raise ExportError(f"{path}: the name must end in {listed}, as in attempt{suffixes[0]}")
    folder = path.parent
    try:
        if path.is_dir():
            raise ExportError(f"{path}: is a folder; give the name of a file")
        if folder.exists() and not folder.is_dir():
            raise ExportError(f"{path}: {folder} is a file, not a folder")
        if not folder.exists():
            raise ExportError(f"{path}: the folder {folder} does not exist; make it first")
        if path.exists() and not os.access(path, os.W_OK):
            raise ExportError(f"{path}: the file exists and may not be overwritten")
        # Only the attempt tells: the permission bits say nothing to root, nor about a read-only file system. The
        # length of the name leaves room for the suffix that the file has until it is complete.
        with tempfile.NamedTemporaryFile(dir=folder, prefix=f".{path.name}.", suffix=".part"):
            pass
    except OSError as error:
        raise ExportError(f"{path}: nothing can be written to the folder {folder}: {error.strerror}") from None
