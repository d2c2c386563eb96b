"""What a name or path that is to be checked is: a scenario, an arm, a hand, a part or a bare model."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ...config import Scenario
from ...exceptions import ConfigurationError
from ...files import read_toml
from ...robots import hands, names
from ...scenarios import names as scenarios
from ...scenarios import object_files
from .registry import Kind

MODEL_SUFFIXES = (".urdf", ".xml", ".mjcf")
"""Suffixes of robot models."""

MESH_SUFFIXES = (".stl", ".obj")
"""Suffixes of meshes, which are parts."""


def kind_of(name: str) -> Kind:
    """Return what a name or path names.

    Raises:
        ConfigurationError: It names nothing that can be checked.
    """
    path = Path(name)
    if name in names():
        return "arm"
    if f"hands/{name.removeprefix('hands/')}" in hands():
        return "hand"
    if name in scenarios():
        return "scenario"
    if name in object_files():
        return "part"
    if path.is_dir():
        table: dict[str, Any] = read_toml(path / "robot.toml") if (path / "robot.toml").is_file() else {}
        if "hand" in table or "robot" in table:
            return "hand" if "hand" in table else "arm"
        raise ConfigurationError(
            f"{name}: is a folder without a robot.toml that has a table [robot] or [hand]; for a bare URDF or MJCF "
            "give the file, with --tool-frame and --write"
        )
    suffix = path.suffix.lower()
    if suffix in MODEL_SUFFIXES:
        return "model"
    if suffix in MESH_SUFFIXES:
        return "part"
    if suffix == ".toml":
        return "scenario" if set(read_toml(path)) <= set(Scenario.model_fields) else "part"
    known = ", ".join([*names(), *hands(), *scenarios()])
    raise ConfigurationError(
        f"{name!r:.80} is no scenario, arm, hand or object; give one of {known}, or the path of a .toml, .urdf or .xml "
        "file, or of a folder"
    )
