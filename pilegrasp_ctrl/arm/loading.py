"""Pinocchio models from files: a URDF with tool and base, or the folder of an arm that ships with the library."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..exceptions import ModelError
from ..types import MassProperties, Pose, frozen_array

_JOINT_KEYS = {
    "q_lower": "position_lower",
    "q_upper": "position_upper",
    "velocity_limit": "velocity",
    "torque_limit": "torque_peak",
    "armature": "armature",
    "friction_coulomb": "friction_coulomb",
    "friction_viscous": "friction_viscous",
}
"""Argument of `ArmModel.from_urdf` -> key in the table [joints] of `robot.toml`."""

_MOTOR_KEYS = {"joint_to_motor": "joint_to_motor", "motor_torque_limit": "motor_torque_peak"}
"""Argument of `ArmModel.from_urdf` -> key in the table [transmission] of `robot.toml`."""


class ArmFolder(NamedTuple):
    """The description in the folder of an arm.

    Attributes:
        urdf: Path of the URDF.
        flange_frame: Name of the frame that carries the tool.
        joint_names: Names of the joints, in the order of the numbers.
        numbers: Arguments of `ArmModel.from_urdf` for limits, friction, inertia of the drives and transmission.
    """

    urdf: Path
    flange_frame: str
    joint_names: tuple[str, ...]
    numbers: dict[str, Any]


def read_arm_folder(name: str) -> ArmFolder:
    """Return the description of an arm in `robots/<name>/robot.toml`.

    Raises:
        ModelError: The folder does not exist, or its `robot.toml` does not describe an arm.
    """
    from ..robots import description, path

    table = description(name)
    try:
        robot, joints = table["robot"], table["joints"]
        numbers = {argument: joints[key] for argument, key in _JOINT_KEYS.items()}
        if "transmission" in table:
            for argument, key in _MOTOR_KEYS.items():
                numbers[argument] = table["transmission"][key]
        return ArmFolder(path(name, robot["urdf"]), robot["flange_frame"], tuple(joints["names"]), numbers)
    except KeyError as error:
        raise ModelError(f"{name}: its robot.toml has no key {error}, so it is not an arm; add the key") from None


def read_urdf(
    path: str | PathLike[str],
    tool_frame: str,
    name: str,
    *,
    transform_tool_to_frame: Pose | None,
    tool: MassProperties | None,
    base: Pose | None,
    gravity: ArrayLike,
    locked_joints: Sequence[str] | Mapping[str, float],
    armature: ArrayLike | None,
) -> tuple[pin.Model, str]:
    """Return a URDF's model with tool, base and locked joints, and the name of the controlled frame.

    The arguments are those of `ArmModel.from_urdf`; error messages use `name`.

    Raises:
        ModelError: The file cannot be read, or an argument does not fit it.
    """
    if not Path(path).is_file():
        raise ModelError(f"{path}: no such URDF file; give the path of an existing one")
    try:
        model = pin.buildModelFromUrdf(str(path))
    except (ValueError, RuntimeError) as error:
        raise ModelError(f"{path}: not a URDF that Pinocchio can read: {error}") from error
    model = _with_revolute_joints(model)
    model.gravity.linear = frozen_array(gravity, (3,), "gravity")
    followers = _mimic_joints(path)
    model = _lock_joints(model, locked_joints, name)
    if model.nv == 0:
        raise ModelError(f"{name}: no joint is left to control; lock fewer joints")
    for joint in list(model.names)[1:]:
        if joint in followers:
            raise ModelError(f"{name}: joint {joint!r} follows {followers[joint]!r} (mimic); add it to locked_joints")
    parent = frame_id(model, tool_frame, name)
    if base is not None:
        _place_base(model, base)
    if armature is not None:
        if np.shape(armature) != (model.nv,) or not np.all(np.asarray(armature) >= 0.0):
            raise ModelError(f"{name}: armature must be {model.nv} numbers that are not negative")
        model.armature = np.array(armature, dtype=np.float64)
    frame = model.frames[parent]
    if tool is not None:
        body = pin.Inertia(tool.mass, np.array(tool.center_of_mass), np.array(tool.inertia))
        model.appendBodyToJoint(frame.parentJoint, body, frame.placement)
    _check_masses(model, name)
    if transform_tool_to_frame is None:
        return model, tool_frame
    controlled = f"{tool_frame}_tool"
    placement = frame.placement * _se3(transform_tool_to_frame)
    model.addFrame(pin.Frame(controlled, frame.parentJoint, parent, placement, pin.FrameType.OP_FRAME))
    return model, controlled


def _se3(pose: Pose) -> pin.SE3:
    return pin.SE3(np.array(pose.rotation), np.array(pose.translation))


def frame_id(model: pin.Model, name: str, arm: str) -> int:
    """Return the index of a frame; a link is preferred, because a link and a joint may share a name.

    Error messages use the name of the `arm`.

    Raises:
        ModelError: No frame has this name.
    """
    named = [index for index, frame in enumerate(model.frames) if frame.name == name]
    if not named:
        links = ", ".join(frame.name for frame in model.frames if frame.type == pin.FrameType.BODY)
        raise ModelError(f"{arm}: no frame {name!r} for the tool; the links are {links}")
    return next((index for index in named if model.frames[index].type == pin.FrameType.BODY), named[0])


def _with_revolute_joints(model: pin.Model) -> pin.Model:
    """Return the model with continuous joints as revolute joints without position limits, so that nq = nv.

    Pinocchio describes a continuous joint by cosine and sine of its angle.
    """
    if model.nq == model.nv:
        return model
    plain = pin.Model()
    plain.name, plain.gravity = model.name, model.gravity
    for index in range(1, model.njoints):
        joint = model.joints[index]
        q, v = joint.idx_q, slice(joint.idx_v, joint.idx_v + joint.nv)
        lower, upper = model.lowerPositionLimit[q : q + joint.nq], model.upperPositionLimit[q : q + joint.nq]
        if joint.nq == 2 and joint.nv == 1:
            joint, lower, upper = _revolute(joint), np.array([-np.inf]), np.array([np.inf])
        limits = model.effortLimit[v], model.velocityLimit[v], lower, upper
        plain.addJoint(model.parents[index], joint, model.jointPlacements[index], model.names[index], *limits)
        plain.inertias[index] = model.inertias[index]
    for frame in list(model.frames)[1:]:
        plain.addFrame(frame, False)
    plain.armature = model.armature
    return plain


def _revolute(joint: pin.JointModel) -> Any:
    """Return the revolute joint about the axis of a continuous one."""
    data = joint.createData()
    joint.calc(data, np.array([1.0, 0.0]))
    axis = np.array(data.S).reshape(6)[3:]
    aligned = {"RUBX": pin.JointModelRX, "RUBY": pin.JointModelRY, "RUBZ": pin.JointModelRZ}
    make = aligned.get(joint.shortname().removeprefix("JointModel"))
    return pin.JointModelRevoluteUnaligned(axis) if make is None else make()


def _mimic_joints(path: str | PathLike[str]) -> dict[str, str]:
    """Return the joints of a URDF that follow another joint, and that joint."""
    found = {}
    for joint in ElementTree.parse(path).getroot().iter("joint"):
        mimic = joint.find("mimic")
        if mimic is not None:
            found[joint.get("name", "")] = mimic.get("joint", "")
    return found


def _check_masses(model: pin.Model, name: str) -> None:
    """Refuse a joint that moves no mass: its torque could not be computed."""
    data = model.createData()
    pin.computeSubtreeMasses(model, data)
    for index in range(1, model.njoints):
        if not data.mass[index] > 0.0:
            raise ModelError(
                f"{name}: the links that joint {model.names[index]!r} moves have no mass; give them inertials, or give "
                "the tool's mass properties"
            )


def _lock_joints(model: pin.Model, joints: Sequence[str] | Mapping[str, float], name: str) -> pin.Model:
    if isinstance(joints, str):
        raise ModelError(f"{name}: locked_joints = {joints!r} must be a list of names, such as [{joints!r}]")
    if not joints:
        return model
    q = pin.neutral(model)
    for joint in joints:
        if not model.existJointName(joint):
            raise ModelError(f"{name}: no joint {joint!r} to lock; the joints are {', '.join(list(model.names)[1:])}")
        if isinstance(joints, Mapping):
            q[model.joints[model.getJointId(joint)].idx_q] = joints[joint]
    return pin.buildReducedModel(model, sorted({model.getJointId(joint) for joint in joints}), q)


def _place_base(model: pin.Model, base: Pose) -> None:
    transform = _se3(base)
    for joint in range(1, model.njoints):
        if model.parents[joint] == 0:
            model.jointPlacements[joint] = transform * model.jointPlacements[joint]
    for frame in model.frames[1:]:
        if frame.parentJoint == 0:
            frame.placement = transform * frame.placement
