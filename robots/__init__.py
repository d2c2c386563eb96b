"""Finder of the arms and hands. Each has a folder with URDF, MJCF, and the source of every number in `robot.toml`."""

from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from typing import Any

from pilegrasp_ctrl.exceptions import ModelError
from pilegrasp_ctrl.files import read_toml

_ROOT = Path(__file__).resolve().parent

PANDA_FINGERS = ("panda_finger_joint1", "panda_finger_joint2")
"""Names of the gripper's joints in the Panda's URDF; lock them to get an arm with seven joints."""

_PANDA_URDF = "urdf/panda.urdf"


def path(*parts: str) -> Path:
    """Return the file or folder `parts` below this folder, such as `path("wam7", "wam7.urdf")`.

    Raises:
        ModelError: No file or folder has this name.
    """
    found = _ROOT.joinpath(*parts)
    if not parts or ".." in found.parts or not found.is_relative_to(_ROOT) or not found.exists():
        known = ", ".join([*names(), *hands()])
        raise ModelError(f"no model file '{'/'.join(parts)}'; the robots are: {known}")
    return found


def description(name: str) -> dict[str, Any]:
    """Return the parsed `robot.toml` of an arm ("wam7") or a hand ("hands/rbo_hand2"); SI units.

    Raises:
        ModelError: No robot has this name, or its file is not valid TOML.
    """
    if name not in (known := [*names(), *hands()]):
        raise ModelError(f"no robot '{name}'; the robots are: {', '.join(known)}")
    return read_toml(path(name, "robot.toml"), error=ModelError)


def names() -> list[str]:
    """Return the names of the arms."""
    return _described(_ROOT)


def hands() -> list[str]:
    """Return the names of the hands, such as "hands/shovel"."""
    return [f"hands/{name}" for name in _described(_ROOT / "hands")]


def panda_urdf() -> Path:
    """Return the Panda's URDF from the package example-robot-data, which contains no Python module.

    Raises:
        ModelError: The package is not installed, or does not contain the file.
    """
    try:
        package = distribution("example-robot-data")
    except PackageNotFoundError:
        raise ModelError("the Panda needs the package example-robot-data; pip install example-robot-data") from None
    found = [file for file in package.files or () if str(file).endswith(_PANDA_URDF)]
    if not found:
        raise ModelError(f"example-robot-data has no file {_PANDA_URDF}; pip install 'example-robot-data>=6'")
    return Path(str(package.locate_file(found[0])))


def _described(folder: Path) -> list[str]:
    """Return the names of the subfolders with a `robot.toml`."""
    return sorted(file.parent.name for file in folder.glob("*/robot.toml"))
