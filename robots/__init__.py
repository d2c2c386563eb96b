"""Models of arms and hands: one folder each, with URDF, MJCF, and `robot.toml` for every number and its source."""

import tomllib
from pathlib import Path
from typing import Any

from pilegrasp_ctrl.exceptions import ModelError

_ROOT = Path(__file__).resolve().parent


def path(*parts: str) -> Path:
    """Return the file or folder `parts` below this folder, such as `path("wam7", "wam7.urdf")`.

    Raises:
        ModelError: where nothing has this name.
    """
    found = _ROOT.joinpath(*parts)
    if not parts or ".." in found.parts or not found.is_relative_to(_ROOT) or not found.exists():
        known = ", ".join([*names(), *hands()])
        raise ModelError(f"no model file '{'/'.join(parts)}'; the robots are: {known}")
    return found


def description(name: str) -> dict[str, Any]:
    """Return the parsed `robot.toml` of an arm ("wam7") or a hand ("hands/rbo_hand2"); SI units.

    Raises:
        ModelError: where there is no such robot, or its file is not valid TOML.
    """
    if name not in (known := [*names(), *hands()]):
        raise ModelError(f"no robot '{name}'; the robots are: {', '.join(known)}")
    file = path(name, "robot.toml")
    try:
        return tomllib.loads(file.read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise ModelError(f"{file} is not valid TOML: {error}") from error


def names() -> list[str]:
    """Return the names of the arms."""
    return _described(_ROOT)


def hands() -> list[str]:
    """Return the names of the hands, such as "hands/shovel"."""
    return [f"hands/{name}" for name in _described(_ROOT / "hands")]


def _described(folder: Path) -> list[str]:
    return sorted(file.parent.name for file in folder.glob("*/robot.toml"))
