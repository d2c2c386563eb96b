"""Finder of the arms and hands. Each has a folder with URDF, MJCF, and the source of every number in `robot.toml`."""

from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from typing import Any

from pilegrasp_ctrl.exceptions import ModelError
from pilegrasp_ctrl.files import MAX_MESH_SIZE, read_file, read_toml, resolved
from pilegrasp_ctrl.provenance import digest

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
    """Return the parsed `robot.toml` of an arm ("wam7"), a hand ("hands/rbo_hand2") or a user's folder; SI units.

    Raises:
        ModelError: No robot has this name, the folder has no `robot.toml`, or the file is not valid TOML.
    """
    return read_toml(folder_of(name) / "robot.toml", error=ModelError)


def is_folder(name: str) -> bool:
    """Return whether a scenario's text names a folder of the user rather than a robot that ships: it has a slash."""
    return "/" in name and name not in hands()


def folder_of(name: str) -> Path:
    """Return the folder of an arm ("wam7"), of a hand ("hands/rbo_hand2"), or of the user ("path/to/folder").

    Raises:
        ModelError: No robot has this name, or the folder has no `robot.toml`.
    """
    known = [*names(), *hands()]
    if name in known:
        return path(name)
    if is_folder(name):
        if not (Path(name) / "robot.toml").is_file():
            raise ModelError(
                f"{name}: is no folder that holds a robot.toml; `pilegrasp check --help` tells how to make one"
            )
        if resolved(Path(name) / "robot.toml", ModelError).parent != resolved(Path(name), ModelError):
            raise ModelError(f"{name}: its robot.toml is a link that leads out of the folder; copy the file")
        return Path(name)
    hint = f"; the folder of this name is './{name}'" if Path(name).is_dir() else ""
    listed = ", ".join(known)
    raise ModelError(f"no robot {name!r:.80}; choose from {listed}, or give the path of a folder, with a slash{hint}")


def model_file(name: str, key: str) -> Path:
    """Return the file that the table [robot] of a description names under `key`: "urdf" or "mjcf".

    A file is in the robot's folder. With the key `package` it is among the files of an installed Python package, none
    of whose code is loaded.

    Raises:
        ModelError: The description names no such file, or it is not where it is said to be.
    """
    robot = description(name).get("robot")
    robot = robot if isinstance(robot, dict) else {}
    file = robot.get(key)
    if not isinstance(file, str):
        raise ModelError(f"{name}: its robot.toml has no key robot.{key}; give the name of the file")
    if "package" in robot:
        return package_file(str(robot["package"]), file)
    folder = folder_of(name)
    if not resolved(folder / file, ModelError).is_relative_to(resolved(folder, ModelError)):
        raise ModelError(f"{name}: robot.{key} = {file!r:.80} leads out of the folder; copy the file into it")
    return folder / file


def package_file(package: str, file: str) -> Path:
    """Return a data file of an installed package, given by the end of its path.

    Raises:
        ModelError: The package is not installed, or does not contain the file.
    """
    try:
        found = [each for each in distribution(package).files or () if f"/{each}".endswith(f"/{file}")]
    except (PackageNotFoundError, ValueError):
        raise ModelError(f"{file} is in the package {package}, which is not installed; pip install {package}") from None
    if not found:
        raise ModelError(f"the installed package {package} has no file {file}; install a newer one")
    return Path(str(found[0].locate()))


def gains_file(name: str, controller: str) -> Path:
    """Return the gains of a controller ("operational_space" or "impedance") for an arm.

    They are the arm's own, or those of `robots/gains`, which suit an arm whose gains nobody has tuned.
    """
    own = folder_of(name) / f"{controller}.toml"
    return own if own.is_file() else path("gains", f"{controller}.toml")


def folder_digest(name: str) -> str:
    """Return a digest of a robot's or hand's files; README and Python files are left out, as no result uses them."""
    folder = folder_of(name)
    files = sorted(file for file in folder.rglob("*") if file.is_file() and file.suffix not in (".md", ".py", ".pyc"))
    parts = [(str(file.relative_to(folder)), read_file(file, MAX_MESH_SIZE, error=ModelError)) for file in files]
    robot = description(name).get("robot")
    if isinstance(robot, dict) and "package" in robot:
        parts += [(key, model_file(name, key).read_bytes()) for key in ("urdf", "mjcf") if key in robot]
    return digest(parts)


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
    return package_file("example-robot-data", _PANDA_URDF)


def _described(folder: Path) -> list[str]:
    """Return the names of the subfolders with a `robot.toml`."""
    return sorted(file.parent.name for file in folder.glob("*/robot.toml"))
