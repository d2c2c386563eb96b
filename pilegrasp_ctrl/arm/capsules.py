"""Capsules of an arm or hand: stated in the `robot.toml` of its folder, or fitted to the geometry of its model."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..exceptions import ArgumentError, ModelError
from ..files import read_toml
from ..robots import description, hands, model_file, names, path
from .capsule import Capsule
from .capsule_fit import fit_capsule
from .collision_balls import balls_of_model
from .model_paths import check_paths, package_folders

if TYPE_CHECKING:
    from .model import ArmModel

_KEYS = ("link", "from", "to", "radius")
"""Keys of a table [[collision.capsules]] in `robot.toml`."""


def capsules_of(source: Any, *, frame: str | None = None, folders: Iterable[str | PathLike[str]] = ()) -> list[Capsule]:
    """Return the capsules of an arm or a hand.

    Args:
        source: Name of an arm ("wam7") or hand ("hands/rbo_hand2") of the library, a folder, or a model: a URDF or MJCF
            file, a `mujoco.MjModel` or a `mujoco.MjSpec`. A folder states capsules in its `robot.toml`, in tables
            [[collision.capsules]] with link, from, to and radius [m]. Those of a model, and of a folder that states
            none, are fitted: one for each link, around all of its collision geometry.
        frame: Frame that carries a hand; the tables of a hand leave out `link`.
        folders: Folders that hold the packages of a URDF's meshes, besides the folders above the URDF.

    Raises:
        ModelError: The source does not exist, cannot be read or has no collision geometry, or a table is wrong.
    """
    known = [*names(), *hands()]
    if isinstance(source, str) and source in known:
        folder, table, label = path(source), description(source), source
    elif isinstance(source, str | PathLike) and (Path(source) / "robot.toml").is_file():
        folder = Path(source)
        table, label = read_toml(folder / "robot.toml", error=ModelError), f"{folder}/"
    else:
        if isinstance(source, str) and not Path(source).exists() and "." not in source:
            raise ModelError(f"no arm or hand {source!r}: choose from {', '.join(known)}, or give a folder or a model")
        return _fitted(source, folders)
    stated = table.get("collision", {})
    if not isinstance(stated, Mapping) or "capsules" not in stated:
        robot = table.get("robot", {})
        keys = [key for key in ("urdf", "mjcf") if isinstance(robot, Mapping) and key in robot]
        if not keys:
            raise ModelError(f"{folder.name}: its robot.toml has no [[collision.capsules]], and names no model")
        file = model_file(label, keys[0])
        if "package" in robot:
            return _fitted(file, folders)
        check_paths(file, folder)
        return _fitted(file, [*folders, *package_folders(file, folder)], above=False)
    return [_stated(entry, frame, folder.name) for entry in stated["capsules"]]


def arm_capsules(robot: str, arm: ArmModel) -> list[Capsule]:
    """Return the capsules of an arm, without those of links that are left out of it.

    Args:
        robot: Name of an arm that ships, or path of a folder.
        arm: The arm, as `ArmModel.load` reads it.

    Raises:
        ModelError: The folder states no capsules, and none can be fitted to its model.
    """
    links = {frame.name for frame in arm.pinocchio_model.frames}
    return [capsule for capsule in capsules_of(robot) if capsule.frame in links]


def _stated(entry: Any, frame: str | None, label: str) -> Capsule:
    where = f"{label}: [[collision.capsules]] in its robot.toml"
    keys = _KEYS if frame is None else _KEYS[1:]
    if not isinstance(entry, Mapping) or not set(keys) <= set(entry) <= set(_KEYS):
        hint = "; give frame=, the name of the frame that carries the hand" if frame is None else ""
        raise ModelError(f"{where} must each have the keys {', '.join(_KEYS)}{hint}")
    try:
        return Capsule(entry.get("link", frame), entry["from"], entry["to"], entry["radius"])
    except ArgumentError as error:
        raise ModelError(f"{where}: {error}") from None


def _fitted(source: Any, folders: Iterable[str | PathLike[str]], above: bool = True) -> list[Capsule]:
    found = balls_of_model(source, folders, above)
    if not found:
        raise ModelError(
            f"{source!s:.80}: has no collision geometry; state capsules with Capsule(frame, start, end, radius)"
        )
    return [Capsule(link, *fit_capsule(*balls)) for link, balls in found.items()]
