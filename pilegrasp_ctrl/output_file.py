"""Files that the user asked for: refused before the work starts, where they could not be written after it."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from .exceptions import ExportError


def check_output(path: Path, suffix: str) -> None:
    """Find out whether `path` can be written, and leave nothing behind.

    Raises:
        ExportError: where the suffix differs, the folder does not exist, or the file may not be written.
    """
    if path.suffix != suffix:
        raise ExportError(f"{path}: the name must end in {suffix}")
    if path.is_dir():
        raise ExportError(f"{path}: is a folder; give the name of a file")
    if not path.parent.is_dir():
        raise ExportError(f"{path}: the folder {path.parent} does not exist; make it first")
    if path.exists() and not os.access(path, os.W_OK):
        raise ExportError(f"{path}: the file exists and may not be overwritten")
    try:
        # Only the attempt tells: the permission bits say nothing to root, nor about a read-only file system.
        with tempfile.TemporaryFile(dir=path.parent):
            pass
    except OSError as error:
        raise ExportError(f"{path}: nothing can be written to the folder {path.parent}: {error.strerror}") from None
