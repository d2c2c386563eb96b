"""Files of the user: read TOML, check an output path before the work, write whole files, and lock a folder."""

from __future__ import annotations

import os
import tempfile
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from .exceptions import ConfigurationError, ExportError, PilegraspError

VIEWS = (".html", ".png", ".gif", ".mp4")
"""Suffixes of the files that show a recording: page, contact sheet and movies."""

STUDY_FILE = "study.db"
"""Name of the store in the folder of a study."""

RECORDINGS = "recordings"
"""Name of the folder of recordings beside the store of a study."""


def read_toml(path: Path, what: str = "", error: type[PilegraspError] = ConfigurationError) -> dict[str, Any]:
    """Return the table in a TOML file.

    Args:
        path: File to read.
        what: Content of the file, for the error about a missing file, such as "of gains".
        error: Type of the error.

    Raises:
        error: The file is missing, cannot be read, or is not valid TOML.
    """
    try:
        return tomllib.loads(path.read_bytes().decode("utf-8-sig"))
    except FileNotFoundError:
        raise error(f"{path}: no such file{f' {what}' if what else ''}") from None
    except OSError as problem:
        raise error(f"{path}: cannot be read: {problem.strerror}") from None
    # tomllib raises further errors for huge integers and deep nesting.
    except (ValueError, RecursionError) as problem:
        raise error(f"{path}: is not valid TOML: {problem}") from None


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Yield a path beside `path` to write to. The file is renamed to `path` at the end, and removed after an error.

    A reader sees either the old content or all of the new.

    Raises:
        OSError: The file cannot be written.
    """
    beside = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        yield beside
        os.replace(beside, path)
    finally:
        beside.unlink(missing_ok=True)


def write_whole(path: Path, content: bytes, *, durable: bool = False) -> None:
    """Write a file so that a reader sees either the old content or all of the new.

    Args:
        path: File to write.
        content: Bytes of the file.
        durable: Whether to wait until the bytes are on the disk, so that they survive a power failure.

    Raises:
        OSError: The file cannot be written; nothing is left behind.
    """
    with whole_file(path) as beside, beside.open("wb") as file:
        file.write(content)
        if durable:
            file.flush()
            os.fsync(file.fileno())


def write_output(path: Path, content: bytes, what: str = "file", *, durable: bool = False) -> None:
    """Write a file that the user asked for, by `write_whole`.

    Args:
        path: File to write.
        content: Bytes of the file.
        what: Content of the file, for the error, such as "page".
        durable: Whether to wait until the bytes are on the disk.

    Raises:
        ExportError: The file cannot be written.
    """
    try:
        write_whole(path, content, durable=durable)
    except OSError as error:
        raise ExportError(f"{path}: the {what} cannot be written: {error.strerror}") from None


def make_folder(folder: Path) -> None:
    """Make a folder of the user, and those above it, if it is missing.

    Raises:
        ExportError: The folder cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ExportError(f"{folder}: the folder cannot be made: {error.strerror}") from None


@contextmanager
def locked(folder: Path, what: str) -> Iterator[None]:
    """Keep a second writer out of the folder; the lock ends with the process, even if it is killed.

    Args:
        folder: Folder to lock.
        what: Name of the writer, for the error, such as "study".

    Raises:
        ConfigurationError: Another process holds the lock.
        ExportError: Nothing can be written to the folder.
    """
    import fcntl

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


def check_output(path: Path, *suffixes: str) -> None:
    """Check that `path` ends in one of `suffixes` and can be written; leave nothing behind.

    Raises:
        ExportError: The suffix is not one of these, the folder does not exist, or the file cannot be written.
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
        # Permission bits do not cover root and read-only file systems, so a file is written. Its name is as long as
        # that of the incomplete file.
        with tempfile.NamedTemporaryFile(dir=folder, prefix=f".{path.name}.", suffix=".part"):
            pass
    except OSError as error:
        raise ExportError(f"{path}: nothing can be written to the folder {folder}: {error.strerror}") from None
