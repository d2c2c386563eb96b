"""One writer in a folder at a time."""

from __future__ import annotations

import fcntl
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ..exceptions import ConfigurationError, ExportError


@contextmanager
def locked(folder: Path, what: str = "search") -> Iterator[None]:
    """Keep a second writer out of the folder while this one writes there; the lock goes with its process.

    Raises:
        ConfigurationError: where another process holds it.
        ExportError: where nothing can be written to the folder.
    """
    try:
        opened = (folder / ".lock").open("w")
    except OSError as error:
        raise ExportError(f"{folder}: nothing can be written to the folder: {error.strerror}") from None
    with opened as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise ConfigurationError(
                f"{folder}: another {what} writes there now; wait for it or choose another --out"
            ) from None
        yield
