"""The arm in a MuJoCo spec: from an MJCF that its folder holds for the simulation, or from bodies as plain numbers."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import mujoco
import numpy as np

from ..exceptions import ModelError
from ..planning.simulated_arm import SMALLEST_INERTIA, SMALLEST_MASS, ArmBodies, ArmBody, ArmJoint, SimulatedArm

PREFIX = "arm/"
"""Beginning of the names of an arm's bodies, so that none is that of an object, a wall or a part of the hand."""

METAL = (0.78, 0.79, 0.81, 1.0)
"""Colour of the arm (rgba)."""

DRAWN_GROUP = 2
"""MuJoCo's geom group of shapes that are drawn."""

CONTACT_BIT = 1
"""Contact type and affinity of the arm's shapes, by which links touch one another, table and walls; chosen."""


class MountedArm(NamedTuple):
    """Places of an arm in a spec.

    Attributes:
        base: Body of the base.
        flange: Site of the flange.
        joints: Number of joints.
        beside_table: Names of the bodies that may be beside the table, below its top.
    """

    base: Any
    flange: Any
    joints: int
    beside_table: tuple[str, ...]


def file_of(arm: SimulatedArm) -> str | None:
    """Return the MJCF with which a spec for the arm begins; None if its bodies are to be added to an empty one."""
    return None if isinstance(arm.source, ArmBodies) else str(arm.source)


def mount_arm(spec: mujoco.MjSpec, arm: SimulatedArm) -> MountedArm:
    """Add the arm to a spec that is empty or read from `file_of(arm)`, and return where it is.

    Raises:
        ModelError: The MJCF does not hold the arm's joints, motors, base or flange.
    """
    if isinstance(arm.source, ArmBodies):
        return _add_bodies(spec, arm, arm.source)
    joints, motors = tuple(joint.name for joint in spec.joints), tuple(motor.target for motor in spec.actuators)
    if joints != arm.joint_names or motors != joints:
        raise ModelError(
            f"{arm.source}: must hold the joints {', '.join(arm.joint_names)} and one motor for each, in this order; "
            f"its joints are {', '.join(joints) or 'none'}, its motors move {', '.join(motors) or 'none'}"
        )
    for name, found in ((arm.base, spec.body(arm.base)), (arm.flange, spec.site(arm.flange))):
        if found is None:
            what = "body" if name == arm.base else "site"
            raise ModelError(f"{arm.source}: has no {what} {name!r}, which robot.toml names; add it")
    return MountedArm(spec.body(arm.base), spec.site(arm.flange), len(joints), arm.beside_table)


def _add_bodies(spec: mujoco.MjSpec, arm: SimulatedArm, source: ArmBodies) -> MountedArm:
    made: list[Any] = []
    for described in source.bodies:
        parent = made[described.parent] if made else spec.worldbody
        made.append(_add_body(parent, described))
        if described.joint is not None:
            _add_joint(spec, made[-1], f"{made[-1].name}_joint", described.joint)
    for first, second in source.together:
        spec.add_exclude(bodyname1=made[first].name, bodyname2=made[second].name)
    flange = made[source.flange_body].add_site(
        name=f"{PREFIX}flange", pos=source.flange.translation, quat=_quaternion(source.flange.rotation)
    )
    beside = tuple(PREFIX + body.name for body in source.bodies if body.name in arm.beside_table)
    return MountedArm(made[0], flange, len(arm.joint_names), beside)


def _add_body(parent: Any, described: ArmBody) -> Any:
    body = parent.add_body(
        name=PREFIX + described.name, pos=described.pose.translation, quat=_quaternion(described.pose.rotation)
    )
    if described.joint is not None:
        body.explicitinertial = True
        body.mass, body.ipos = max(described.mass, SMALLEST_MASS), described.center_of_mass
        I = described.inertia if np.any(described.inertia) else SMALLEST_INERTIA * np.eye(3)  # noqa: E741
        body.fullinertia = [I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]]
    for capsule in described.shapes:
        ball = bool(np.all(capsule.start == capsule.end))
        place = {"pos": capsule.start} if ball else {"fromto": [*capsule.start, *capsule.end]}
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_SPHERE if ball else mujoco.mjtGeom.mjGEOM_CAPSULE,
            size=[capsule.radius, 0.0, 0.0],
            rgba=METAL,
            group=DRAWN_GROUP,
            mass=0.0,
            contype=CONTACT_BIT,
            conaffinity=CONTACT_BIT,
            **place,
        )
    return body


def _add_joint(spec: mujoco.MjSpec, body: Any, name: str, joint: ArmJoint) -> None:
    limited = math.isfinite(joint.lower) or math.isfinite(joint.upper)
    body.add_joint(
        name=name,
        type=mujoco.mjtJoint.mjJNT_SLIDE if joint.slides else mujoco.mjtJoint.mjJNT_HINGE,
        axis=joint.axis,
        limited=int(limited),
        range=[max(joint.lower, -UNLIMITED), min(joint.upper, UNLIMITED)] if limited else [0.0, 0.0],
        armature=joint.armature,
        damping=np.array([joint.viscous, 0.0, 0.0]),
        frictionloss=joint.coulomb,
    )
    motor = spec.add_actuator(name=name, trntype=mujoco.mjtTrn.mjTRN_JOINT, target=name)
    motor.set_to_motor()
    if math.isfinite(joint.torque_limit):
        motor.forcelimited = motor.ctrllimited = 1
        motor.forcerange = motor.ctrlrange = [-joint.torque_limit, joint.torque_limit]


UNLIMITED = 1e3
"""Position in place of a limit on one side that does not exist [rad, m]; chosen, beyond what a joint turns."""


def _quaternion(rotation: Any) -> Any:
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(rotation).ravel())
    return quaternion
