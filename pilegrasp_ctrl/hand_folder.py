"""Finder of the hands: what an arm can carry at its flange. A hand is a folder, which ships or is the user's."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path
from typing import Any

from . import robots
from .exceptions import ModelError, remedy_for
from .files import MAX_MESH_SIZE, read_file, read_toml, resolved
from .hand_description import BUILDER_PARAMETERS
from .plugins import PACKAGE, is_plugin, plugin_digest

MAX_FOLDER_FILES = 500
"""Largest number of files in the folder of a hand [-]; chosen, far above what a model needs."""

NOT_COUNTED = (".md", ".py", ".pyc", ".txt", ".png", ".jpg")
"""Suffixes of files that no result depends on."""


def names() -> list[str]:
    """Return the names of the hands that ship."""
    return [name.removeprefix("hands/") for name in robots.hands()]


def is_path(name: str) -> bool:
    """Return whether a text names a folder: it contains a slash."""
    return "/" in name


def beside(place: Path, name: str) -> str:
    """Return the path of a hand's folder that a file in the folder `place` names; it contains a slash, too."""
    path = str(place / name)
    return path if is_path(path) else f"./{path}"


def label(name: str) -> str:
    """Return the name of a hand, without the path of its folder."""
    return Path(name).name if is_path(name) else name


def folder(name: str) -> Path:
    """Return the folder of a hand.

    Args:
        name: Name of a hand that ships, or the path of a folder with a `robot.toml`; a path contains a slash.

    Raises:
        ModelError: No hand has this name, or there is no such folder.
    """
    if is_path(name):
        place = Path(name)
        if not os.path.isfile(place / "robot.toml"):
            raise ModelError(f"hand = {name!r}: is no folder that holds a robot.toml; give the folder of a hand")
        if resolved(place / "robot.toml", ModelError).parent != resolved(place, ModelError):
            raise ModelError(f"hand = {name!r}: its robot.toml is a link that leads out of the folder; copy the file")
        return place
    if name not in names():
        otherwise = f"choose from {', '.join(names())}, or give a folder, such as ./{name}"
        raise ModelError(f"no hand is called {name!r}; {remedy_for(name, names(), otherwise)}")
    return robots.path("hands", name)


def parameters(name: str) -> dict[str, Any]:
    """Return the parsed `robot.toml` of a hand.

    Raises:
        ModelError: No hand has this name, or its file is not valid TOML.
    """
    return read_toml(folder(name) / "robot.toml", error=ModelError)


def digests(name: str) -> list[str]:
    """Return the SHA-256 digests of the files in the folder of a hand that may decide a result, names included.

    A builder that is not part of this library counts by the digest of its module.

    Raises:
        ConfigurationError: The module of the builder cannot be found.
        ModelError: The folder does not exist, holds too many files, or a file cannot be read.
    """
    place = folder(name)
    files = sorted(file for file in place.rglob("*") if file.is_file() and file.suffix.lower() not in NOT_COUNTED)
    if len(files) > MAX_FOLDER_FILES:
        raise ModelError(f"{place}: holds more than {MAX_FOLDER_FILES} files; give a folder with one hand")
    found = []
    for file in files:
        content = read_file(file, MAX_MESH_SIZE, "of a hand", ModelError)
        found.append(hashlib.sha256(f"{file.relative_to(place)}\0".encode() + content).hexdigest())
    mount = parameters(name).get("hand")
    builder = mount.get("builder") if isinstance(mount, dict) else None
    if isinstance(builder, str) and is_plugin(builder) and not builder.startswith(f"{PACKAGE}."):
        found.append(plugin_digest(builder, f"{label(name)}: hand.builder", BUILDER_PARAMETERS, named=True))
    return found
