"""Which joints an arm keeps: each with one coordinate, continuous ones converted, the others locked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import Any

import numpy as np
import pinocchio as pin

from ..exceptions import ModelError
from .options import listed

Locks = Mapping[str, float | None]
"""Type of the joints to lock: name -> position [rad or m], None for the neutral position."""


_LIMITS = {
    "lowerPositionLimit": -np.inf,
    "upperPositionLimit": np.inf,
    "lowerEffortLimit": -np.inf,
    "effortLimit": np.inf,
    "lowerVelocityLimit": -np.inf,
    "velocityLimit": np.inf,
}
"""Vector of limits in a `pin.Model` -> a value that contradicts no other."""


def simple_joints(model: pin.Model) -> pin.Model:
    """Return a copy of a model with continuous joints as revolute joints without position limits.

    Pinocchio describes a continuous joint by cosine and sine of its angle. All other joints stay as they are.
    """
    if model.nq == model.nv:
        return pin.Model(model)
    plain = pin.Model()
    plain.name, plain.gravity = model.name, model.gravity
    lower: list[float] = []
    upper: list[float] = []
    for index in range(1, model.njoints):
        joint = model.joints[index]
        own = slice(joint.idx_q, joint.idx_q + joint.nq)
        if joint.nq == 2 and joint.nv == 1:
            joint = _revolute(joint)
            lower, upper = [*lower, -np.inf], [*upper, np.inf]
        else:
            lower, upper = [*lower, *model.lowerPositionLimit[own]], [*upper, *model.upperPositionLimit[own]]
        plain.addJoint(model.parents[index], joint, model.jointPlacements[index], model.names[index])
        plain.inertias[index] = model.inertias[index]
    for frame in list(model.frames)[1:]:
        plain.addFrame(frame, False)
    plain.lowerPositionLimit, plain.upperPositionLimit = np.array(lower), np.array(upper)
    plain.effortLimit, plain.velocityLimit, plain.armature = model.effortLimit, model.velocityLimit, model.armature
    return plain


def _revolute(joint: pin.JointModel) -> Any:
    """Return the revolute joint about the axis of a continuous one."""
    data = joint.createData()
    joint.calc(data, np.array([1.0, 0.0]))
    axis = np.array(data.S).reshape(6)[3:]
    aligned = {"RUBX": pin.JointModelRX, "RUBY": pin.JointModelRY, "RUBZ": pin.JointModelRZ}
    make = aligned.get(joint.shortname().removeprefix("JointModel"))
    return pin.JointModelRevoluteUnaligned(axis) if make is None else make()


def joints_to_lock(
    arm: str,
    names: Sequence[str],
    chain: Sequence[str],
    followers: Mapping[str, str],
    joints: Sequence[str] | int | None,
    locked_joints: Sequence[str] | Mapping[str, float],
) -> Locks:
    """Return the joints to lock, so that those remain that are to be kept.

    Args:
        arm: Name of the arm, for error messages.
        names: Names of all joints of the model.
        chain: Names of the movable joints of one coordinate between base and tool frame, in that order.
        followers: Joints that follow another joint (mimic), and that joint.
        joints: Names of the joints to keep, or how many of the chain's first joints to keep; None for all.
        locked_joints: Names of joints to lock at their neutral position, or a mapping from name to position.

    Raises:
        ModelError: An argument does not fit the joints.
    """
    locked = _locked(arm, names, locked_joints)
    if joints is None:
        return locked
    if isinstance(joints, bool | np.bool_) or not isinstance(joints, int | np.integer | Sequence):
        raise ModelError(f"{arm}: joints = {joints!r} must be a list of joint names, or a number of joints")
    if isinstance(joints, int | np.integer):
        free = [joint for joint in chain if joint not in locked and joint not in followers]
        if not free:
            raise ModelError(f"{arm}: no movable joint lies between base and tool frame; choose another tool frame")
        if not 1 <= joints <= len(free):
            raise ModelError(
                f"{arm}: joints = {joints} must be a number from 1 to {len(free)}, the movable joints between base and "
                f"tool frame: {listed(free)}"
            )
        kept = set(free[: int(joints)])
    else:
        kept = set(_names(arm, "joints", joints))
        for joint in joints:
            if joint not in names:
                raise ModelError(f"{arm}: no joint {joint!r} to keep; the joints are {listed(names)}")
            if joint in locked:
                raise ModelError(f"{arm}: joint {joint!r} stands in joints and in locked_joints; take it out of one")
    for joint in chain:
        if joint not in kept and joint not in locked and followers.get(joint) in kept:
            raise ModelError(
                f"{arm}: joint {joint!r}, between base and tool frame, follows {followers[joint]!r} (mimic), which is "
                "kept; name it in locked_joints if it is to stand still"
            )
    return {joint: locked.get(joint) for joint in names if joint not in kept}


def _locked(arm: str, names: Sequence[str], joints: Sequence[str] | Mapping[str, float]) -> Locks:
    """Return the checked argument `locked_joints`."""
    locked: dict[str, float | None] = dict.fromkeys(_names(arm, "locked_joints", joints))
    for joint in locked:
        if joint not in names:
            raise ModelError(f"{arm}: no joint {joint!r} to lock; the joints are {listed(names)}")
        if isinstance(joints, Mapping):
            locked[joint] = _position(arm, joint, joints[joint])
    return locked


def _names(arm: str, what: str, joints: Any) -> list[str]:
    if isinstance(joints, str):
        raise ModelError(f"{arm}: {what} = {joints!r} must be a list of names, such as [{joints!r}]")
    try:
        names = list(joints)
    except TypeError:
        raise ModelError(f"{arm}: {what} = {joints!r} must be a list of names of joints") from None
    for name in names:
        if not isinstance(name, str):
            raise ModelError(f"{arm}: {what} holds {name!r}; it must hold names of joints")
    return names


def _position(arm: str, joint: str, value: Any) -> float | None:
    if value is None:
        return None
    try:
        position = float(value)
    except (TypeError, ValueError):
        position = float("nan")
    if not isfinite(position):
        raise ModelError(
            f"{arm}: locked_joints holds {value!r} as the position of {joint!r}; give one finite number [rad or m]"
        )
    return position


def lock_joints(model: pin.Model, locks: Locks, arm: str) -> pin.Model:
    """Return a model without the joints to lock, and spoil `model`; `joints_to_lock` has checked the names.

    Raises:
        ModelError: A joint of several coordinates is to be locked at a number.
    """
    if not locks:
        return model
    q = pin.neutral(model)
    for joint, position in locks.items():
        if position is not None:
            index = model.getJointId(joint)
            if model.joints[index].nq != 1:
                raise ModelError(
                    f"{arm}: joint {joint!r} has {model.joints[index].nq} coordinates and is locked at its neutral "
                    "position only; give None as its position"
                )
            q[model.joints[index].idx_q] = position
    kept = [joint for joint in list(model.joints)[1:] if model.names[joint.id] not in locks]
    at_q = [joint.idx_q + i for joint in kept for i in range(joint.nq)]
    at_v = [joint.idx_v + i for joint in kept for i in range(joint.nv)]
    limits = {name: getattr(model, name)[at_q if "Position" in name else at_v] for name in _LIMITS}
    # Limits that contradict each other are refused later, with the joint's name, unless arguments replace them.
    for name, harmless in _LIMITS.items():
        getattr(model, name)[:] = harmless
    reduced = pin.buildReducedModel(model, sorted(model.getJointId(joint) for joint in locks), q)
    for name, limit in limits.items():
        getattr(reduced, name)[:] = limit
    return reduced


def check_joints(model: pin.Model, followers: Mapping[str, str], arm: str) -> None:
    """Refuse joints that are not one motor with one number each.

    Raises:
        ModelError: No joint is left, a joint follows another, or a joint is neither revolute nor prismatic.
    """
    if model.njoints == 1:
        raise ModelError(f"{arm}: no joint is left to control; lock fewer joints")
    for index in range(1, model.njoints):
        joint, name = model.joints[index], model.names[index]
        if name in followers:
            raise ModelError(f"{arm}: joint {name!r} follows {followers[name]!r} (mimic); add it to locked_joints")
        kind = joint.shortname().removeprefix("JointModel")
        if kind.startswith("Mimic"):
            raise ModelError(
                f"{arm}: joint {name!r} follows another joint (mimic); build the model without mimic joints"
            )
        if (joint.nq, joint.nv) != (1, 1):
            what = "a floating base" if kind == "FreeFlyer" else f"of the kind {kind}"
            raise ModelError(
                f"{arm}: joint {name!r} is {what}, neither revolute nor prismatic; lock it, or keep other joints"
            )
