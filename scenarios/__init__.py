"""Finder of the shipped scenarios and objects. Beside it are their TOML files and short scripts."""

from __future__ import annotations

import hashlib
import os
import re
from pathlib import Path

from pilegrasp_ctrl.exceptions import ConfigurationError, remedy_for
from pilegrasp_ctrl.files import MAX_MESH_SIZE, MAX_TOML_SIZE, read_file, read_toml

PIECES_SUFFIX = ".pieces.obj"
"""End of the name of a file that stores the convex pieces of a mesh, after the name of the mesh."""

MESHES = (".stl", ".obj")
"""Suffixes of meshes, which an object's file names."""

_OPTED_OUT = re.compile(rb"^[ \t]*hull[ \t]*=[ \t]*true[ \t]*(#[^\n]*)?\r?(\n|\Z)", re.MULTILINE)

FOLDER = Path(__file__).resolve().parent
"""Folder of the shipped scenarios."""


def names() -> list[str]:
    """Return the names of the shipped scenarios, in alphabetical order."""
    return sorted(path.stem for path in FOLDER.glob("*.toml"))


def object_files() -> dict[str, Path]:
    """Return the files of the shipped objects by name, in alphabetical order."""
    return {path.stem: path for path in sorted((FOLDER / "objects").glob("*.toml"))}


def object_digests(path: Path) -> list[str]:
    """Return the SHA-256 digests of an object's file, of the meshes that it names, and of their stored pieces.

    A line `hull = true` does not count: it means what every mesh meant before there was this key.

    Raises:
        ConfigurationError: A file cannot be read, or the object's file is not TOML.
    """
    table = read_toml(path)
    places = [place for place in (table, *table.values()) if isinstance(place, dict)]
    meshes = [path.parent / place["file"] for place in places if isinstance(place.get("file"), str)]
    for mesh in meshes:
        if not os.path.lexists(mesh):
            raise ConfigurationError(f"{mesh}: cannot be read: No such file or directory")
    stored = [mesh.with_name(mesh.name + PIECES_SUFFIX) for mesh in meshes]
    contents = [_OPTED_OUT.sub(b"", read_file(path, MAX_TOML_SIZE))]
    contents += [read_file(mesh, MAX_MESH_SIZE, "of a mesh") for mesh in meshes]
    contents += [read_file(pieces, MAX_MESH_SIZE, "of convex pieces") for pieces in stored if pieces.is_file()]
    return [hashlib.sha256(content).hexdigest() for content in contents]


def is_file(name: str) -> bool:
    """Return whether a text names a file: it ends in `.toml` or contains a slash."""
    return name.lower().endswith(".toml") or "/" in name


def object_parts(text: str) -> list[str]:
    """Split `pile.object` at each + into names and files; the path of a file that exists may contain a +.

    Raises:
        ConfigurationError: A part is a mesh; the error says what to write.
    """
    parts = [text] if is_file(text) and os.path.isfile(text) else text.split("+")
    for part in parts:
        if part.lower().endswith(MESHES):
            name = Path(part).name
            lines = ('shape = "mesh"', f'file = "{name}"', 'unit = "mm"', "mass = 0.1", "friction.lateral = 0.3")
            raise ConfigurationError(
                f"pile.object = {part!r} is a mesh, which says neither unit nor mass; write {Path(part).stem}.toml "
                f"beside it with the five lines {', '.join(f'`{line}`' for line in lines)}, then "
                f"--set pile.object={Path(part).with_suffix('.toml')}; mass is in kg"
            )
    return parts


def find(name: str | Path) -> Path:
    """Return the TOML file of a scenario.

    Args:
        name: One of `names()`, or the path of a file: a `Path`, or a text that ends in `.toml` or contains a slash.

    Raises:
        ConfigurationError: No shipped scenario has this name.
    """
    if isinstance(name, Path) or is_file(name):
        return Path(name)
    if name in names():
        return FOLDER / f"{name}.toml"
    remedy = remedy_for(name, names(), f"choose from {', '.join(names())}, or give a .toml file")
    raise ConfigurationError(f"no scenario is called {name!r}; {remedy}")
