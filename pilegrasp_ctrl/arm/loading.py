"""Arms from files: the format of a model file, and the folder of an arm with its `robot.toml`."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from os import PathLike, fspath
from pathlib import Path
from typing import Any, NamedTuple, cast
from xml.etree import ElementTree

import pinocchio as pin

from ..exceptions import ModelError, remedy_for
from ..files import resolved
from ..robots import description, folder_of, hands, model_file, names
from .joints import check_joints
from .mjcf import compile_mjcf, read_mjcf
from .model_paths import check_paths
from .options import ArmOptions, merged
from .urdf import read_urdf, without_links

_JOINT_KEYS = {
    "q_lower": "position_lower",
    "q_upper": "position_upper",
    "velocity_limit": "velocity",
    "torque_limit": "torque_peak",
    "armature": "armature",
    "friction_coulomb": "friction_coulomb",
    "friction_viscous": "friction_viscous",
}
"""Option of `ArmModel` -> key in the table [joints] of `robot.toml`; each may be absent where the model has it."""

_OTHER_JOINT_KEYS = ("names", "locked", "torque_continuous")
"""Further keys in the table [joints]: joints to keep, positions of others, and numbers that are only told."""

_MOTOR_KEYS = {"joint_to_motor": "joint_to_motor", "motor_torque_limit": "motor_torque_peak"}
"""Option of `ArmModel` -> key in the table [transmission] of `robot.toml`."""


class ArmFolder(NamedTuple):
    """The description in the folder of an arm.

    Attributes:
        model: Path of the URDF or MJCF.
        flange_frame: Name of the frame that carries the tool.
        joint_names: Names of the joints, in the order of the numbers.
        locked_joints: Positions of joints that are not in `joint_names`, where they are not the neutral ones.
        options: Options of `ArmModel`: name, limits, friction, inertia of the drives and transmission.
        without: Links of the model that are no part of the arm, such as a gripper, with all that they carry.
    """

    model: Path
    flange_frame: str
    joint_names: tuple[str, ...]
    locked_joints: Mapping[str, float]
    options: ArmOptions
    without: tuple[str, ...] = ()


def read_arm_folder(name: str | PathLike[str]) -> ArmFolder:
    """Return the description of an arm: `name` is that of a robot that ships with the library, or a folder.

    Raises:
        ModelError: There is no such arm, or its `robot.toml` does not describe an arm.
    """
    shipped = [*names(), *hands()]
    if isinstance(name, str) and name in shipped:
        source, table, label = name, description(name), name
    else:
        folder = Path(_path_of(name))
        if not os.path.isfile(folder / "robot.toml"):
            raise ModelError(
                f"no arm {str(name)!r}: it is neither a robot of the library ({', '.join(names())}) nor a folder that "
                "holds a robot.toml"
            )
        label, source = resolved(folder, ModelError).name, f"{folder}/"
        table = description(source)
    try:
        robot, joints = _table(table, "robot", label), _table(table, "joints", label)
        key = "urdf" if "urdf" in robot else "mjcf"
        _ = robot[key]
        model = model_file(source, key)
        if "package" not in robot and model.is_file():
            check_paths(model, folder_of(source))
        known = [*_JOINT_KEYS.values(), *_OTHER_JOINT_KEYS]
        for key in joints:
            if key not in known:
                remedy = remedy_for(key, known, f"the keys are {', '.join(known)}")
                raise ModelError(f"{label}: robot.toml has an unknown key joints.{key}; {remedy}")
        options: dict[str, Any] = {"name": label} | {
            option: joints[key] for option, key in _JOINT_KEYS.items() if key in joints
        }
        if "transmission" in table:
            transmission = _table(table, "transmission", label)
            options |= {option: transmission[key] for option, key in _MOTOR_KEYS.items()}
        flange, kept = robot["flange_frame"], joints["names"]
    except KeyError as error:
        raise ModelError(f"{label}: its robot.toml has no key {error}, so it is not an arm; add the key") from None
    if not isinstance(kept, list) or not all(isinstance(joint, str) for joint in kept):
        raise ModelError(f"{label}: joints.names in its robot.toml must be a list of names of joints")
    locked = joints.get("locked", {})
    if not isinstance(locked, dict):
        raise ModelError(f"{label}: joints.locked in its robot.toml must be a table from joint to position")
    without = robot.get("without", [])
    if not isinstance(without, list) or not all(isinstance(link, str) for link in without):
        raise ModelError(f"{label}: robot.without in its robot.toml must be a list of names of links")
    return ArmFolder(model, flange, tuple(kept), locked, cast(ArmOptions, options), tuple(without))


def _table(parent: Mapping[str, Any], key: str, label: str) -> dict[str, Any]:
    table: dict[str, Any] = parent[key]
    if not isinstance(table, dict):
        raise ModelError(f"{label}: {key} in its robot.toml must be a table [{key}]")
    return table


def read_model(
    source: Any,
    tool_frame: str,
    joints: Sequence[str] | int | None,
    locked_joints: Sequence[str] | Mapping[str, float],
    options: ArmOptions,
    without: Sequence[str] = (),
) -> tuple[pin.Model, ArmOptions]:
    """Return the model in a URDF or MJCF, whichever it is, and the options of `ArmModel`: the user's and the file's.

    Args:
        source: Path of the file, or a `mujoco.MjModel` or `mujoco.MjSpec`.
        tool_frame: Name of the frame that carries the tool.
        joints: Names of the joints to keep, or how many of the chain's first joints to keep; None for all.
        locked_joints: Names of joints to lock at their neutral position, or a mapping from name to position.
        options: Options that the user gives.
        without: Links to leave out, with all that they carry.

    Raises:
        ModelError: The file cannot be read, or an argument does not fit it.
    """
    weight_given = options.get("gravity") is not None
    if type(source).__module__.partition(".")[0] == "mujoco" and type(source).__name__ in ("MjModel", "MjSpec"):
        name = options.get("name") or _model_name(source) or "arm"
        mj = compile_mjcf(source, name)
        read = read_mjcf(mj, name, tool_frame, joints, locked_joints, weight_given)
    else:
        file = Path(_path_of(source))
        name = options.get("name") or file.stem
        root = _read_xml(file)
        if root.tag == "mujoco":
            mj = compile_mjcf(file, str(file), without)
            read = read_mjcf(mj, name, tool_frame, joints, locked_joints, weight_given)
        elif root.tag == "robot":
            without_links(root, without, str(file))
            read = read_urdf(root, str(file), name, tool_frame, joints, locked_joints)
        else:
            raise ModelError(f"{file}: has the root <{root.tag}>; a URDF has the root <robot>, an MJCF <mujoco>")
    check_joints(read.model, read.followers, name)
    return read.model, merged(cast(ArmOptions, read.friction), options, {"name": name})


def _model_name(model: Any) -> str:
    """Return the name of a MuJoCo model; that of a compiled one is the first of its names."""
    if hasattr(model, "modelname"):
        return str(model.modelname)
    name: str = model.names.split(b"\0", 1)[0].decode(errors="replace")
    return name


def _path_of(source: Any) -> str:
    try:
        return str(fspath(source))
    except TypeError:
        raise ModelError(f"{source!r} is not the path of a model; give the path of a URDF or MJCF file") from None


def _read_xml(file: Path) -> ElementTree.Element:
    if file.is_dir():
        raise ModelError(f"{file}: is a folder; ArmModel.load reads the folder of an arm")
    if not file.is_file():
        raise ModelError(f"{file}: no such URDF or MJCF file; give the path of an existing one")
    try:
        return ElementTree.parse(file).getroot()
    except (ElementTree.ParseError, LookupError, ValueError) as error:
        raise ModelError(f"{file}: not a URDF or MJCF file, because it is not XML: {error}") from None
    except OSError as error:
        raise ModelError(f"{file}: cannot be read: {error.strerror}") from None
