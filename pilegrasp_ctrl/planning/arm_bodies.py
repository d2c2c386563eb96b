"""Builds the arm for a simulator from its folder, through the model that the controllers use."""

from __future__ import annotations

from functools import lru_cache
from itertools import combinations
from typing import Any

import numpy as np

from ..arm.capsule import Capsule
from ..arm.capsules import arm_capsules
from ..arm.controllability import spread_postures
from ..arm.frames import frame_id
from ..arm.model import ArmModel
from ..exceptions import ModelError
from ..limits.collision_geometry import Geometry, Pair
from ..robots import description, model_file
from ..types import Array, Pose
from ..vectors import norm
from .simulated_arm import DEFAULT_BASE_RADIUS, ArmBodies, ArmBody, ArmJoint, ArmSpread, LinkShape, SimulatedArm

OFTEN_TOGETHER = 0.1
"""Share of the postures in which two links overlap from which their contact is left out of the simulation; chosen. The
capsules around such links stand for shapes that fit together."""

UNSTATED_POSTURES = 16
"""Number of postures, spread over the joints' ranges, from which the search begins if none is stated; chosen."""


@lru_cache(maxsize=8)
def build_arm(robot: str, digest: str) -> SimulatedArm:
    """Return an arm for the simulator; the digest of its files makes a changed folder another arm."""
    arm, table = ArmModel.load(robot), description(robot)
    names, postures, spread = arm.joint_names, _postures(arm, table, robot), _spread(table, robot)
    if "urdf" in table["robot"] and "mjcf" in table["robot"]:
        keys = ("base_frame", "flange_frame")
        for key in keys:
            if not isinstance(table["robot"].get(key), str):
                raise ModelError(f"{robot}: its robot.toml has no key robot.{key}, the name in the MJCF; add the key")
        base, flange = (table["robot"][key] for key in keys)
        beside = _names(table, "beside_table", robot) or (base,)
        return SimulatedArm(robot, names, model_file(robot, "mjcf"), base, flange, beside, postures, spread)
    source = arm_bodies(arm, arm_capsules(robot, arm), postures)
    beside = _names(table, "beside_table", robot) or bodies_beside_table(source, _base_radius(table))
    base = source.bodies[0].name
    return SimulatedArm(robot, names, source, base, arm.tool_frame, beside, postures, spread)


def arm_bodies(arm: ArmModel, capsules: list[Capsule], postures: tuple[Array, ...] = ()) -> ArmBodies:
    """Return the bodies of an arm whose base is at the origin.

    Args:
        arm: Arm without tool.
        capsules: Shapes of its links.
        postures: Postures (nv,) in which no two links touch.
    """
    model = arm.pinocchio_model
    shapes: list[list[LinkShape]] = [[] for _ in range(model.njoints)]
    for capsule in capsules:
        frame = model.frames[frame_id(model, capsule.frame, arm.name)]
        start, end = (frame.placement.act(point) for point in (capsule.start, capsule.end))
        shapes[frame.parentJoint].append(LinkShape(start, end, capsule.radius))
    bodies = [ArmBody("base", -1, Pose(np.zeros(3)), None, 0.0, np.zeros(3), np.zeros((3, 3)), tuple(shapes[0]))]
    for index in range(1, model.njoints):
        inertia, place = model.inertias[index], model.jointPlacements[index]
        bodies.append(
            ArmBody(
                name=_link_of(model, index),
                parent=int(model.parents[index]),
                pose=Pose(place.translation, place.rotation),
                joint=_joint(arm, model, index),
                mass=float(inertia.mass),
                center_of_mass=np.array(inertia.lever),
                inertia=np.array(inertia.inertia),
                shapes=tuple(shapes[index]),
            )
        )
    flange = model.frames[frame_id(model, arm.tool_frame, arm.name)]
    return ArmBodies(
        tuple(bodies),
        int(flange.parentJoint),
        Pose(flange.placement.translation, flange.placement.rotation),
        _together(arm, model, capsules, postures),
    )


def _joint(arm: ArmModel, model: Any, index: int) -> ArmJoint:
    joint = model.joints[index]
    row, data = joint.idx_v, joint.createData()
    joint.calc(data, np.zeros(model.nq))
    motion = np.array(data.S).ravel()
    slides = bool(np.any(motion[:3]))
    return ArmJoint(
        axis=motion[:3] if slides else motion[3:],
        slides=slides,
        lower=float(arm.q_lower[row]),
        upper=float(arm.q_upper[row]),
        torque_limit=float(arm.torque_limit[row]),
        armature=float(model.armature[row]),
        coulomb=float(arm.friction_coulomb[row]),
        viscous=float(arm.friction_viscous[row]),
    )


def _link_of(model: Any, index: int) -> str:
    """Return the name of the first link on a joint; that of the joint if it carries none."""
    links = [frame.name for frame in model.frames if frame.parentJoint == index and frame.type.name == "BODY"]
    return links[0] if links else model.names[index]


def _together(
    arm: ArmModel, model: Any, capsules: list[Capsule], postures: tuple[Array, ...]
) -> tuple[tuple[int, int], ...]:
    """Return pairs of bodies whose shapes overlap in many postures, or in one of `postures`, or that a joint joins."""
    carriers = [int(model.frames[frame_id(model, capsule.frame, arm.name)].parentJoint) for capsule in capsules]
    joined = {(int(model.parents[index]), index) for index in range(1, model.njoints)}
    pairs = [
        Pair(first, second, "")
        for first, second in combinations(range(len(capsules)), 2)
        if carriers[first] != carriers[second]
    ]
    if pairs:
        geometry = Geometry(model, capsules, (), pairs)
        spread = list(spread_postures(arm.q_lower, arm.q_upper))
        times = np.zeros(len(pairs))
        for q in spread:
            geometry.place(q)
            times += geometry.distances() < 0.0
        touching = times > OFTEN_TOGETHER * len(spread)
        for q in postures:
            geometry.place(q)
            touching |= geometry.distances() < 0.0
        for pair, touches in zip(pairs, touching.tolist(), strict=True):
            if touches:
                first, second = sorted((carriers[pair.first], carriers[pair.second]))
                joined.add((first, second))
    return tuple(sorted(joined))


def bodies_beside_table(bodies: ArmBodies, radius: float) -> tuple[str, ...]:
    """Return the bodies whose joint stays within `radius` of the first joint's axis, whatever the posture."""
    away: list[float] = []
    for body in bodies.bodies:
        # The first joint turns about its own axis, so the way to it does not count.
        away.append(away[body.parent] + norm(body.pose.translation) if body.parent > 0 else 0.0)
    return tuple(body.name for body, far in zip(bodies.bodies, away, strict=True) if far <= radius)


def _base_radius(table: dict[str, object]) -> float:
    room = table.get("room")
    return float(room.get("base_radius", DEFAULT_BASE_RADIUS)) if isinstance(room, dict) else DEFAULT_BASE_RADIUS


def _names(table: dict[str, object], key: str, robot: str) -> tuple[str, ...]:
    contact = table.get("contact", {})
    names = contact.get(key, []) if isinstance(contact, dict) else None
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise ModelError(f"{robot}: contact.{key} in its robot.toml must be a list of names of links")
    return tuple(names)


def _spread(table: dict[str, object], robot: str) -> ArmSpread:
    stated = table.get("spread", {})
    values = {key: stated.get(key, 0.0) for key in ArmSpread._fields} if isinstance(stated, dict) else {"": None}
    for key, value in values.items():
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 <= value < 1.0:
            raise ModelError(f"{robot}: spread.{key} in its robot.toml must be a share from 0 to below 1")
    return ArmSpread(**values)


def _postures(arm: ArmModel, table: dict[str, object], robot: str) -> tuple[Array, ...]:
    """Return the stated postures: those of the search, or the home posture alone; the middle one without any."""
    stated = table.get("postures", {})
    if not isinstance(stated, dict):
        raise ModelError(f"{robot}: postures in its robot.toml must be a table [postures]")
    given = stated.get("search", [stated["home"]] if "home" in stated else [])
    postures = [np.array(posture, dtype=np.float64) for posture in given] if _is_numbers(given, arm.nv) else None
    if postures is None:
        raise ModelError(
            f"{robot}: the postures in its robot.toml must be lists of {arm.nv} numbers, one for each of "
            f"{', '.join(arm.joint_names)}"
        )
    return tuple(postures) or tuple(list(spread_postures(arm.q_lower, arm.q_upper))[:UNSTATED_POSTURES])


def _is_numbers(postures: object, count: int) -> bool:
    return isinstance(postures, list) and all(
        isinstance(posture, list) and len(posture) == count and all(isinstance(value, int | float) for value in posture)
        for posture in postures
    )
