"""Origin of a result: versions of the packages and a digest of the code that decide it."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from functools import cache
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path
from re import match

ABSENT = "absent"
"""Version of a package that is not installed."""


def version_of(package: str) -> str:
    """Return the version of an installed package, or `ABSENT`."""
    try:
        return version(package)
    except PackageNotFoundError:
        return ABSENT


VERSION = "0+uninstalled" if version_of("pilegrasp") == ABSENT else version_of("pilegrasp")
"""Version of this library."""

DECIDING_PACKAGES = ("mujoco", "pin", "numpy", "daqp", "mink")
"""Packages that decide the result of every attempt."""

ROOMS: tuple[tuple[str, ...], ...] = (
    ("types", "exceptions", "files", "config", "sections", "provenance", "statistics", "robots", "scenarios"),
    ("arm",),
    ("tasks", "limits", "qp"),
    ("control",),
    ("trajectories", "primitives", "planning", "plant"),
    ("recording", "recording_parts", "analysis"),
    ("sim",),
    ("recorder", "episode", "programs"),
    ("viewer",),
    ("study", "tuning", "validation"),
    ("cli", "scripts", "__init__", "__main__"),
)
"""Rooms and files of the package, lowest first: a room imports from its own row and from the rows above it. `scenarios`
and `robots` are the two finders alone. The scripts in `scenarios/` are the room `scripts`."""

DECIDING_ROOMS = tuple(room for row in ROOMS[: ROOMS.index(("viewer",))] for room in row)
"""Rooms whose code decides the result of an attempt."""


def versions(*more: str) -> dict[str, str]:
    """Return the versions of the library, of the packages that decide a result, and of `more` packages, by name."""
    return {"pilegrasp": VERSION} | {package: version_of(package) for package in (*DECIDING_PACKAGES, *more)}


def dependencies() -> tuple[str, ...]:
    """Return the required packages without extras; `DECIDING_PACKAGES` if the library is not installed."""
    try:
        lines = requires("pilegrasp") or ()
    except PackageNotFoundError:
        return DECIDING_PACKAGES
    names = (match(r"[\w.-]+", line) for line in lines if "extra ==" not in line)
    return tuple(name.group() for name in names if name)


def digest(parts: Iterable[tuple[str, bytes]]) -> str:
    """Return "sha256:" and 32 digits of named contents."""
    total = hashlib.sha256()
    for name, content in parts:
        total.update(f"{name}\0{len(content)}\0".encode() + content)
    return f"sha256:{total.hexdigest()[:32]}"


@cache
def code_digest() -> str:
    """Return a digest of the code that decides a result. It is read once, because imported code does not change."""
    return digest((str(file.relative_to(_PACKAGE)), file.read_bytes()) for file in deciding_files())


def deciding_files() -> list[Path]:
    """Return the files of the rooms that decide a result, in order."""
    return [file for room in DECIDING_ROOMS for file in _files(room)]


_PACKAGE = Path(__file__).resolve().parent
_FINDERS = ("scenarios", "robots")


def _files(room: str) -> list[Path]:
    if room in _FINDERS:
        return [_PACKAGE / room / "__init__.py"]
    return [file for file in sorted([*(_PACKAGE / room).rglob("*.py"), _PACKAGE / f"{room}.py"]) if file.is_file()]
