"""MuJoCo models: the bodies, joints and motors of a compiled model, as a Pinocchio model.

Pinocchio's own reader of MJCF drops the pose of the base and knows neither defaults of the actuators nor `ref`. MuJoCo
therefore compiles the file, and the model is built from what it compiled, in the same order of joints. Positions equal
MuJoCo's `qpos`, and `M`, `h` its inertia and bias. MuJoCo is imported when a model is read, never before.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf
from typing import Any
from warnings import warn

import numpy as np
import pinocchio as pin

from ..exceptions import ModelError, ModelWarning
from ..types import Array
from .file_model import FileModel
from .joints import Locks, joints_to_lock
from .mjcf_couplings import check_couplings, enum_values, followers_in, movers_of
from .options import listed

_ALIGNED = 1.0 - 1e-15
"""Smallest component of a unit axis that counts as parallel to an axis of its frame."""


def compile_mjcf(source: Any, name: str, without: Sequence[str] = ()) -> Any:
    """Return the `mujoco.MjModel` of a file, an `MjSpec` or an `MjModel`.

    Meshes are left out of a file where no mass depends on them, so they need not be there; so are the bodies `without`.

    Raises:
        ModelError: MuJoCo does not compile it.
    """
    import mujoco

    if isinstance(source, mujoco.MjModel):
        return source
    try:
        if isinstance(source, mujoco.MjSpec):
            return source.copy().compile()
        try:
            return _without_meshes(without_bodies(mujoco.MjSpec.from_file(str(source)), without)).compile()
        except ValueError:
            return without_bodies(mujoco.MjSpec.from_file(str(source)), without).compile()
    except (ValueError, RuntimeError) as error:
        raise ModelError(f"{name}: not a model that MuJoCo can compile: {' '.join(str(error).split())}") from None


def without_bodies(spec: Any, bodies: Sequence[str]) -> Any:
    """Take bodies out of a spec, with all that they carry and the actuators of their joints; return it.

    Raises:
        ModelError: A body does not exist.
    """
    for name in bodies:
        body = spec.body(name)
        if body is None:
            known = listed(each.name for each in spec.bodies[1:])
            raise ModelError(f"{spec.modelname}: no body {name!r} to leave out; the bodies are {known}")
        spec.delete(body)
    return spec


def _without_meshes(spec: Any) -> Any:
    """Delete the meshes that give no body its mass."""
    (mesh,) = enum_values("mjtGeom", "mjGEOM_MESH")
    from_geoms = enum_values("mjtInertiaFromGeom", "mjINERTIAFROMGEOM_TRUE")
    for body in [] if int(spec.compiler.inertiafromgeom) in from_geoms else spec.bodies:
        for geom in list(body.geoms) if body.explicitinertial else ():
            if int(geom.type) == mesh:
                spec.delete(geom)
    used = {geom.meshname for geom in spec.geoms}
    for asset in list(spec.meshes):
        if asset.name not in used:
            spec.delete(asset)
    return spec


def read_mjcf(
    mj: Any,
    arm: str,
    tool_frame: str,
    joints: Sequence[str] | int | None,
    locked_joints: Sequence[str] | Mapping[str, float],
    weight_given: bool,
) -> FileModel:
    """Return what a compiled MuJoCo model says.

    Args:
        mj: The compiled model, a `mujoco.MjModel`.
        arm: Name of the arm, for error messages.
        tool_frame: Name of the body or site that carries the tool.
        joints: Names of the joints to keep, or how many of the chain's first joints to keep; None for all.
        locked_joints: Names of joints to lock at their position in the file, or a mapping from name to `qpos`.
        weight_given: Whether the user says what gravity is, so that what the file says of it does not count.

    Raises:
        ModelError: The arm has something that a joint-space model cannot have, or an argument does not fit.
    """
    names = joint_names(mj)
    movers = movers_of(mj, _carrier(mj, tool_frame, arm))
    chain = [names[joint] for joint in movers if mj.jnt_type[joint] in _kinds("HINGE", "SLIDE")]
    followers = {names[joint]: names[leader] for joint, leader in followers_in(mj).items() if leader >= 0}
    locks = joints_to_lock(arm, names, chain, followers, joints, locked_joints)
    kept = {joint for joint, name in enumerate(names) if name not in locks}
    for joint in sorted(kept):
        _check_joint(mj, joint, names[joint], arm)
    check_couplings(mj, kept, names, arm)
    if not weight_given:
        _check_weight(mj, kept, names, arm)
    model = _build(mj, names, locks, arm)
    model.name = arm
    rows = [int(mj.jnt_dofadr[joint]) for joint in sorted(kept)]
    model.armature = _drives(mj, mj.dof_armature, "actuator_armature")[rows]
    friction = {
        "friction_coulomb": np.array(mj.dof_frictionloss[rows]),
        "friction_viscous": _drives(mj, mj.dof_damping, "actuator_damping")[rows],
    }
    return FileModel(model, followers, friction)


def _kinds(*names: str) -> list[int]:
    """Return MuJoCo's numbers of kinds of joints."""
    return enum_values("mjtJoint", *(f"mjJNT_{name}" for name in names))


def joint_names(mj: Any) -> list[str]:
    """Return a name for every joint; one that has none is called after its body."""
    names: list[str] = []
    for joint in range(mj.njnt):
        name = mj.joint(joint).name or f"{_body_name(mj, int(mj.jnt_bodyid[joint]))}_joint"
        while name in names:
            name += "_"
        names.append(name)
    return names


def _body_name(mj: Any, body: int) -> str:
    return mj.body(body).name or f"body{body}"


def _carrier(mj: Any, frame: str, arm: str) -> int:
    """Return the body that carries a frame: the body or the site of this name."""
    bodies, sites = [mj.body(i).name for i in range(mj.nbody)], [mj.site(i).name for i in range(mj.nsite)]
    if frame in bodies and frame:
        return bodies.index(frame)
    if frame in sites and frame:
        return int(mj.site_bodyid[sites.index(frame)])
    raise ModelError(
        f"{arm}: no frame {frame!r} for the tool; the links are {listed(filter(None, bodies[1:]))}"
        + (f"; the sites are {listed(filter(None, sites))}" if any(sites) else "")
    )


def _check_joint(mj: Any, joint: int, name: str, arm: str) -> None:
    if mj.jnt_type[joint] not in _kinds("HINGE", "SLIDE"):
        what = "a free joint" if mj.jnt_type[joint] in _kinds("FREE") else "a ball joint"
        raise ModelError(f"{arm}: joint {name!r} is {what}, neither hinge nor slide; lock it, or keep other joints")
    if mj.jnt_stiffness[joint] != 0.0 or np.any(mj.jnt_stiffnesspoly[joint]):
        warn(
            f"{arm}: joint {name!r} has a spring (stiffness), which the model of the arm leaves out; a controller will "
            "not know its torque",
            ModelWarning,
            stacklevel=5,
        )


def _check_weight(mj: Any, kept: set[int], names: list[str], arm: str) -> None:
    for body in np.flatnonzero(mj.body_gravcomp):
        moved = [joint for joint in movers_of(mj, int(body)) if joint in kept]
        if moved:
            raise ModelError(
                f"{arm}: body {_body_name(mj, int(body))!r}, which joint {names[moved[-1]]!r} moves, has gravcomp = "
                f"{mj.body_gravcomp[body]:g}, so it is held without the motors; give gravity, (0, 0, 0) if all of the "
                "arm is held so, and its true value if the motors carry it"
            )


def _drives(mj: Any, joints: Array, actuators: str) -> Array:
    """Return (nv,) a property of the joints, with that of the actuators, reflected through their gear."""
    total = np.array(joints)
    for actuator, joint in _motors(mj):
        total[mj.jnt_dofadr[joint]] += mj.actuator_gear[actuator, 0] ** 2 * getattr(mj, actuators)[actuator]
    return total


def _motors(mj: Any) -> list[tuple[int, int]]:
    """Return pairs of an actuator and the joint that it turns."""
    own = enum_values("mjtTrn", "mjTRN_JOINT", "mjTRN_JOINTINPARENT")
    return [(i, int(mj.actuator_trnid[i, 0])) for i in range(mj.nactuator) if mj.actuator_trntype[i] in own]


def _torque_limit(mj: Any, joint: int) -> float:
    """Return the torque that the motors of a joint give in both directions; 0 without a motor, inf without a limit."""
    lower = upper = 0.0
    for actuator, moved in _motors(mj):
        if moved == joint:
            force = sorted(mj.actuator_gear[actuator, 0] * np.array(_force_range(mj, actuator)))
            lower, upper = lower + force[0], upper + force[1]
    if mj.jnt_actfrclimited[joint]:
        least, most = mj.jnt_actfrcrange[joint]
        lower, upper = (least, most) if lower == upper == 0.0 else (max(lower, least), min(upper, most))
    return max(0.0, float(min(-lower, upper)))


def _force_range(mj: Any, actuator: int) -> tuple[float, float]:
    """Return the least and the largest force of an actuator; infinite where neither force nor control is limited."""
    lower, upper = -inf, inf
    control = int(mj.actuator_ctrladr[actuator])
    plain = (
        mj.actuator_gaintype[actuator] in enum_values("mjtGain", "mjGAIN_FIXED")
        and mj.actuator_biastype[actuator] in enum_values("mjtBias", "mjBIAS_NONE")
        and mj.actuator_dyntype[actuator] in enum_values("mjtDyn", "mjDYN_NONE", "mjDYN_FILTER", "mjDYN_FILTEREXACT")
    )
    if plain and mj.actuator_ctrllimited[control]:
        lower, upper = sorted(mj.actuator_gainprm[actuator, 0] * mj.actuator_ctrlrange[control])
    if mj.actuator_forcelimited[actuator]:
        least, most = mj.actuator_forcerange[actuator]
        lower, upper = max(lower, least), min(upper, most)
    return lower, upper


def _build(mj: Any, names: list[str], locks: Locks, arm: str) -> pin.Model:
    """Return the tree of bodies with the joints that are not locked."""
    model = pin.Model()
    weightless = mj.opt.disableflags & enum_values("mjtDisableBit", "mjDSBL_GRAVITY")[0]
    model.gravity.linear = np.zeros(3) if weightless else np.array(mj.opt.gravity)
    places: list[tuple[int, pin.SE3]] = [(0, pin.SE3.Identity())]
    for body in range(1, mj.nbody):
        carrier, placement = places[int(mj.body_parentid[body])]
        placement = placement * _transform(mj.body_pos[body], mj.body_quat[body])
        first = int(mj.body_jntadr[body])
        for joint in range(first, first + int(mj.body_jntnum[body])):
            name = names[joint]
            if name in locks:
                placement = placement * _displacement(mj, joint, locks[name], name, arm)
            else:
                carrier, placement = _add_joint(model, mj, joint, name, carrier, placement)
        moments = pin.SE3(_rotation(mj.body_iquat[body]), np.zeros(3)).act(
            pin.Inertia(0.0, np.zeros(3), np.diag(mj.body_inertia[body]))
        )
        inertia = pin.Inertia(float(mj.body_mass[body]), np.array(mj.body_ipos[body]), moments.inertia)
        model.appendBodyToJoint(carrier, inertia, placement)
        places.append((carrier, placement))
        _add_frame(model, mj.body(body).name, carrier, placement, pin.FrameType.BODY)
    for site in range(mj.nsite):
        carrier, placement = places[int(mj.site_bodyid[site])]
        placement = placement * _transform(mj.site_pos[site], mj.site_quat[site])
        _add_frame(model, mj.site(site).name, carrier, placement, pin.FrameType.OP_FRAME)
    return model


def _add_joint(
    model: pin.Model, mj: Any, joint: int, name: str, carrier: int, placement: pin.SE3
) -> tuple[int, pin.SE3]:
    """Add a hinge or slide; return its index and the placement of the body behind it."""
    axis, anchor = np.array(mj.jnt_axis[joint]), np.array(mj.jnt_pos[joint])
    reference = float(mj.qpos0[mj.jnt_qposadr[joint]])
    if mj.jnt_type[joint] in _kinds("HINGE"):
        aligned = (pin.JointModelRX, pin.JointModelRY, pin.JointModelRZ)
        kind, start = pin.JointModelRevoluteUnaligned, pin.SE3(pin.exp3(-reference * axis), np.zeros(3))
    else:
        aligned = (pin.JointModelPX, pin.JointModelPY, pin.JointModelPZ)
        kind, start = pin.JointModelPrismaticUnaligned, pin.SE3(np.eye(3), -reference * axis)
    along = int(np.argmax(axis))
    motion = aligned[along]() if axis[along] >= _ALIGNED else kind(axis)
    lower, upper = mj.jnt_range[joint] if mj.jnt_limited[joint] else (-inf, inf)
    limits = [np.array([value]) for value in (_torque_limit(mj, joint), inf, lower, upper)]
    index = model.addJoint(carrier, motion, placement * pin.SE3(np.eye(3), anchor) * start, name, *limits)
    return index, pin.SE3(np.eye(3), -anchor)


def _displacement(mj: Any, joint: int, position: float | None, name: str, arm: str) -> pin.SE3:
    """Return the transform through a locked joint."""
    start = int(mj.jnt_qposadr[joint])
    if position is None:
        return pin.SE3.Identity()
    if mj.jnt_type[joint] not in _kinds("HINGE", "SLIDE"):
        raise ModelError(
            f"{arm}: joint {name!r} has several coordinates and is locked at its position in the file only; give None "
            "as its position"
        )
    axis, anchor = np.array(mj.jnt_axis[joint]), pin.SE3(np.eye(3), np.array(mj.jnt_pos[joint]))
    way = (position - float(mj.qpos0[start])) * axis
    motion = pin.SE3(pin.exp3(way), np.zeros(3)) if mj.jnt_type[joint] in _kinds("HINGE") else pin.SE3(np.eye(3), way)
    return anchor * motion * anchor.inverse()


def _add_frame(model: pin.Model, name: str, carrier: int, placement: pin.SE3, kind: pin.FrameType) -> None:
    if name:
        model.addFrame(pin.Frame(name, carrier, 0, placement, kind), False)


def _transform(position: Array, quaternion: Array) -> pin.SE3:
    return pin.SE3(_rotation(quaternion), np.array(position))


def _rotation(quaternion: Array) -> Array:
    rotation: Array = pin.Quaternion(*map(float, quaternion)).matrix()
    return rotation
