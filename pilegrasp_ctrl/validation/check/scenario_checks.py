"""Checks of a scenario: names and keys, reach and collisions of the planned poses, load, contacts and their sources."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import Any, NamedTuple

import mujoco
import numpy as np

from ...config import Scenario, load_scenario, parse_overrides
from ...programs.attempt import Attempt, check, prepare
from ...sim.contact import SUPPORT, Surface, combine
from ...sim.hand import Hand
from ...sim.objects import objects_of
from ...sim.start_posture import StartPosture
from ...types import STANDARD_GRAVITY, Array, Pose
from .picture import draw_poses
from .registry import Finding, Level, Subject, checks

TOUCHING = 0.002
"""Depth of a contact from which it counts as a collision [m]; chosen, above what a resting hand presses."""


class Planned(NamedTuple):
    """The planned poses of an attempt.

    Attributes:
        attempt: The prepared attempt.
        postures: Postures (nv,) by the name of the pose [rad].
    """

    attempt: Attempt
    postures: dict[str, Array]


def _scenario(subject: Subject) -> Scenario:
    return load_scenario(subject.name, parse_overrides(subject.overrides))


@lru_cache(maxsize=2)
def planned(subject: Subject) -> Planned:
    """Return the planned poses, which are found once for all checks of a scenario."""
    scenario = _scenario(subject)
    attempt = prepare(scenario, subject.seed)
    hand, plan, q = Hand.load(scenario.hand, scenario.hand_model), attempt.course.plan, attempt.course.posture
    search = StartPosture(scenario.robot, hand.transform_tool_to_flange, _base_of(attempt))
    postures = {"start": q}
    for pose in plan.waypoints:
        q = search.solve(pose, q)
    if plan.waypoints:
        postures["touch-down"] = q
    postures["end"] = search.solve(plan.end, q)
    return Planned(attempt, postures)


def _base_of(attempt: Attempt) -> Pose:
    """Return the pose of the arm's base, which is the first body of a scene, in the frame of arm and plan."""
    data = attempt.simulation.data
    pose = Pose(data.xpos[1].copy(), data.xmat[1].reshape(3, 3).copy())
    return attempt.transform_known_to_scene.inverse() @ pose


@checks("scenario")
def keys(subject: Subject) -> Iterator[Finding]:
    """Check names, files and keys, without a pile."""
    scenario = _scenario(subject)
    check(scenario)
    yield Finding(
        "fact", "scenario", f"it is a {scenario.program} by {scenario.robot} with {scenario.hand}, and its keys fit"
    )


@checks("scenario")
def reach(subject: Subject) -> Iterator[Finding]:
    """Settle a pile, and find the postures of the planned poses."""
    attempt, postures = planned(subject)
    for name, q in postures.items():
        margin = np.minimum(q - attempt.arm.q_lower, attempt.arm.q_upper - q)
        joint = attempt.arm.joint_names[int(margin.argmin())]
        yield Finding("fact", "reach", f"the {name} is in reach, {margin.min():.2f} rad from the limit of {joint}")


@checks("scenario")
def collisions(subject: Subject) -> Iterator[Finding]:
    """Look for links in walls, table or other links at the planned poses."""
    attempt, postures = planned(subject)
    free = True
    for name, q in postures.items():
        ends = name == "end"
        for text in _collisions(attempt, q, ends):
            free = False
            # The planned end lies behind the support, and the force ends the push before.
            where = "if no force ends the push, then at its end" if ends else f"at the {name}"
            yield Finding("note" if ends else "problem", "collision", f"{where} {text}")
    if free:
        yield Finding("fact", "collision", "no link touches anything at the planned poses")


@checks("scenario")
def load(subject: Subject) -> Iterator[Finding]:
    """Compare torques and forces with what arm and sensor can do."""
    scenario = _scenario(subject)
    attempt, postures = planned(subject)
    arm = attempt.arm
    mass = objects_of(scenario.pile).assign_models(1)[0].mass if scenario.pile.count else 0.0
    spare = np.inf
    for q in postures.values():
        state = arm.update(q, np.zeros(arm.nv))
        torque = np.abs(state.h - mass * STANDARD_GRAVITY[2] * state.J[2])
        spare = min(spare, float(np.min(1.0 - (torque + arm.friction_coulomb) / arm.torque_limit)))
    what = f"holding one object of {mass:.2f} kg" if mass else "holding nothing"
    level: Level = "problem" if spare < 0.0 else "note" if spare < 0.2 else "fact"
    text = f"{what} leaves {100 * spare:.0f} % of the weakest torque limit at the planned poses"
    yield Finding(level, "payload", text)
    reach_of_sensor = float(scenario.sensor.calibration.split("-")[1])
    if scenario.strategy.grasp_force > reach_of_sensor:
        yield Finding(
            "problem",
            "sensor",
            f"grasp_force = {scenario.strategy.grasp_force:g} N is beyond the sensor's {reach_of_sensor:g} N",
        )


@checks("scenario")
def contacts(subject: Subject) -> Iterator[Finding]:
    """Say which friction and restitution are expected, and where they come from."""
    scenario = _scenario(subject)
    if not scenario.pile.count:
        return
    hand, rule = Hand.load(scenario.hand, scenario.hand_model), scenario.sim.contact_rule
    surface = objects_of(scenario.pile).assign_models(1)[0].surface
    sources = {"support": "Cross 2002", "hand": f"the robot.toml of {scenario.hand}", "object": scenario.pile.object}
    pairs: list[tuple[str, Surface, Surface]] = [
        ("object and support", surface, SUPPORT),
        ("two objects", surface, surface),
        ("hand and object", hand.surface, surface),
    ]
    for name, one, other in pairs:
        both = combine(one, other, rule)
        yield Finding(
            "fact",
            "contacts",
            f"{name}: friction {both.lateral:.2f}, restitution {both.restitution:.2f}, by the rule '{rule}'",
        )
    said = ", ".join(f"{what}: {source}" for what, source in sources.items())
    yield Finding("fact", "contacts", f"the sources are: {said}")


@checks("scenario")
def picture(subject: Subject) -> Iterator[Finding]:
    """Draw the planned poses, if asked for."""
    if subject.picture is not None:
        attempt, postures = planned(subject)
        draw_poses(attempt.simulation.scene, attempt.simulation.data, postures, subject.picture)
        yield Finding("fact", "picture", f"{subject.picture} shows the poses: {', '.join(postures)}")


def _collisions(attempt: Attempt, q: Array, ends: bool) -> Iterator[str]:
    """Yield texts about deep contacts of the robot at a posture; at the end of a push the hand may meet objects."""
    scene = attempt.simulation.scene
    model: Any = scene.model
    data = mujoco.MjData(model)
    data.qpos[:] = attempt.simulation.data.qpos
    data.qpos[: scene.arm_dofs] = q
    mujoco.mj_forward(model, data)
    deepest: dict[tuple[str, str], float] = {}
    robot = set(range(1, model.nbody)) - set(scene.objects)
    for index in range(data.ncon):
        contact = data.contact[index]
        bodies = [int(model.geom_bodyid[geom]) for geom in contact.geom]
        with_object = bool(set(bodies) & set(scene.objects))
        if not set(bodies) & robot or (with_object and (ends or set(bodies) & set(scene.hand_bodies))):
            continue
        geoms = [model.geom(int(geom)).name for geom in contact.geom]
        pair = [model.body(body).name if body else geom for body, geom in zip(bodies, geoms, strict=True)]
        if bodies[0] == 0:
            pair.reverse()
        key = (pair[0], pair[1])
        deepest[key] = max(deepest.get(key, 0.0), -float(contact.dist))
    for (one, other), depth in deepest.items():
        hand = one in {model.body(body).name for body in scene.hand_bodies}
        # A hand presses into the table by design, and its fingers bend at the wall.
        if depth > TOUCHING and not (hand and (ends or other == "table")):
            yield f"{one.removeprefix('arm/')} is {1000 * depth:.0f} mm inside {other.removeprefix('arm/')}"
