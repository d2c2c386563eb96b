"""Files of the user: read within a size, check an output path before the work, write whole files, lock a folder."""

from __future__ import annotations

import copy
import os
import re
import secrets
import stat
import tempfile
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any

import tomli_w

from .exceptions import ConfigurationError, ExportError, PilegraspError

VIEWS = (".html", ".png", ".gif", ".mp4", ".csv", ".rrd", ".mcap")
"""Suffixes of the files that show a recording: page, contact sheet and movies."""

STUDY_FILE = "study.db"
"""Name of the store in the folder of a study."""

RECORDINGS = "recordings"
"""Name of the folder of recordings beside the store of a study."""

PART = ".part"
"""Suffix of a file that is not complete yet."""

MAX_TOML_SIZE = 1 << 18
"""Largest TOML file that is read [bytes]; chosen, 30 times that of the largest file that ships."""

MAX_MESH_SIZE = 1 << 25
"""Largest mesh file that is read [bytes]; chosen, three times 200,000 triangles in STL, which MuJoCo reads at most."""

MAX_KEY_PARTS = 32
"""Largest number of parts of a dotted TOML key; chosen. The parser's time grows with the square of the number."""


def read_file(path: Path, limit: int, what: str = "", error: type[PilegraspError] = ConfigurationError) -> bytes:
    """Return the content of a regular file of a limited size, so that no file that never ends is read.

    Args:
        path: File to read.
        limit: Largest size [bytes].
        what: Content of the file, for the error about a missing file, such as "of gains".
        error: Type of the error.

    Raises:
        error: The file is missing, is no regular file, is too large, or cannot be read.
    """
    try:
        # A pipe without a writer would block the opening.
        with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb") as file:
            _check_status(os.fstat(file.fileno()), path, limit, what, error)
            content = file.read(limit + 1)
    except (OSError, ValueError) as problem:
        raise error(_why_unreadable(path, problem, what)) from None
    if len(content) > limit:
        raise error(_too_large(path, limit, what))
    return content


def resolved(path: Path, error: type[PilegraspError] = ConfigurationError) -> Path:
    """Return the absolute path without links.

    Raises:
        error: A link leads to itself, or no file can have this name.
    """
    try:
        return path.resolve()
    # pathlib raises RuntimeError for a loop of links up to Python 3.12.
    except (OSError, RuntimeError, ValueError) as problem:
        reason = problem.strerror if isinstance(problem, OSError) else str(problem)
        raise error(f"{str(path)!r:.300}: cannot be read: {reason}") from None


def check_file(path: Path, limit: int, what: str = "", error: type[PilegraspError] = ConfigurationError) -> None:
    """Check, before another program reads it, that a path is a regular file of a limited size; see `read_file`.

    Raises:
        error: The file is missing, is no regular file, or is too large.
    """
    try:
        _check_status(path.stat(), path, limit, what, error)
    except (OSError, ValueError) as problem:
        raise error(_why_unreadable(path, problem, what)) from None


def _check_status(status: os.stat_result, path: Path, limit: int, what: str, error: type[PilegraspError]) -> None:
    if stat.S_ISDIR(status.st_mode):
        raise error(f"{path}: cannot be read: Is a directory")
    if not stat.S_ISREG(status.st_mode):
        raise error(f"{path}: is not a regular file; give one")
    if status.st_size > limit:
        raise error(_too_large(path, limit, what))


def _why_unreadable(path: Path, problem: OSError | ValueError, what: str) -> str:
    if isinstance(problem, FileNotFoundError):
        return f"{path}: no such file{f' {what}' if what else ''}"
    # The other reason is a null character in the name.
    reason = problem.strerror if isinstance(problem, OSError) else str(problem)
    return f"{path}: cannot be read: {reason}"


def _too_large(path: Path, limit: int, what: str) -> str:
    size = f"{limit >> 20} MiB" if limit >= 1 << 20 else f"{limit >> 10} KiB"
    return f"{path}: is too large for a file{f' {what}' if what else ''}; at most {size} are read"


def parse_toml(text: str) -> dict[str, Any]:
    """Return the table of a TOML text; the caller may change it.

    Raises:
        ValueError: The text is not TOML, or it holds a number, a nesting or a key without end.
    """
    try:
        return copy.deepcopy(_parsed(text))
    except RecursionError:
        raise ValueError("its lists or tables are nested too deeply") from None


@lru_cache(maxsize=32)
def _parsed(text: str) -> dict[str, Any]:
    """Return the table of a TOML text. The files of arm, hand and objects are read again for each attempt."""
    parts, before = 0, None
    kind: str | None
    for token in _TOML_TOKEN.finditer(text):
        kind = token.lastgroup
        if kind == "space":
            continue
        if (kind, before) == ("dot", "key"):
            parts += 1
        elif (kind, before) != ("key", "dot"):
            parts = 0
        if parts >= MAX_KEY_PARTS:
            raise ValueError(f"a key has more than {MAX_KEY_PARTS} parts")
        before = kind
    return tomllib.loads(text)


_TOML_TOKEN = re.compile(
    r"""(?P<space>[ \t]+)|(?P<dot>\.)|(?P<key>[\w-]+|"(?:\\.|[^"\\\n])*"|'[^'\n]*')|(?P<other>\#[^\n]*|.)""", re.DOTALL
)


def read_toml(path: Path, what: str = "", error: type[PilegraspError] = ConfigurationError) -> dict[str, Any]:
    """Return the table in a TOML file.

    Args:
        path: File to read.
        what: Content of the file, for the error about a missing file, such as "of gains".
        error: Type of the error.

    Raises:
        error: The file is missing, cannot be read, or is not valid TOML.
    """
    content = read_file(path, MAX_TOML_SIZE, what, error)
    try:
        return parse_toml(content.decode("utf-8-sig"))
    except ValueError as problem:
        raise error(f"{path}: is not valid TOML: {problem}") from None


def toml_text(table: Mapping[str, Any]) -> str:
    """Return a nested table as the text of a TOML file. A key without a value, None, is left out."""

    def kept(part: Mapping[str, Any]) -> dict[str, Any]:
        given = ((key, value) for key, value in part.items() if value is not None)
        return {key: kept(value) if isinstance(value, Mapping) else value for key, value in given}

    return tomli_w.dumps(kept(table))


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Yield an empty file beside `path` to write to. It is renamed to `path` at the end, and removed after an error.

    A reader sees either the old content or all of the new. The name cannot be guessed, so nobody else's link is there.

    Raises:
        OSError: The file cannot be written.
    """
    beside = path.with_name(f".{path.name}.{secrets.token_hex(4)}{PART}")
    try:
        os.close(os.open(beside, os.O_CREAT | os.O_EXCL | os.O_WRONLY | os.O_CLOEXEC, 0o666))
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

    lock = folder / ".lock"
    try:
        # Nothing is written to it, whatever it is: a received folder may hold a link to another file.
        file = os.open(lock, os.O_RDWR | os.O_CREAT | os.O_NONBLOCK | os.O_CLOEXEC, 0o666)
    except OSError as error:
        raise ExportError(f"{folder}: nothing can be written to the folder: {error.strerror}") from None
    try:
        if not stat.S_ISREG(os.fstat(file).st_mode):
            raise ExportError(f"{lock}: is not a regular file; remove it")
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise ConfigurationError(
                f"{folder}: another {what} writes there now; wait for it or choose another --out"
            ) from None
        yield
    finally:
        os.close(file)


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
        with tempfile.NamedTemporaryFile(dir=folder, prefix=f".{path.name}.", suffix=PART):
            pass
    except OSError as error:
        raise ExportError(f"{path}: nothing can be written to the folder {folder}: {error.strerror}") from None


def cache_folder() -> Path:
    """Return the user's folder for caches."""
    root = Path(os.environ.get("XDG_CACHE_HOME", ""))
    if root.is_absolute():
        return root
    try:
        return Path.home() / ".cache"
    except RuntimeError:  # a user without a home, as in some containers
        return Path(tempfile.gettempdir())
