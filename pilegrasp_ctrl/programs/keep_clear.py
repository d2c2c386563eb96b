"""Limits that keep arm and hand off the walls of crates; they follow the rule by which an attempt is judged."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..arm.capsule import Capsule
from ..arm.capsule_fit import fit_capsule
from ..arm.capsules import arm_capsules, capsules_of
from ..arm.model import ArmModel
from ..config import Scenario
from ..limits.collision_limit import CollisionLimit
from ..limits.obstacles import Box
from ..planning.walls import RIM_HEIGHT, Wall
from ..robots import description
from ..sim.hand import Hand
from ..sim.hand_geometry import outline_of
from ..types import Pose

MARGIN = 0.005
"""Distance kept from a wall [m]; chosen, for the give of the joints' friction and of the wrist."""


def keep_clear(scenario: Scenario, arm: ArmModel, walls: Sequence[Wall]) -> list[CollisionLimit]:
    """Return the limits for the walls of crates.

    The arm's links and the housing of the sensor keep off whole walls. The rest of the hand keeps off the rims alone,
    because palm and fingers may push against a wall below its rim. Fingers and thumb bend, so they are left out.
    """
    crates = [wall for wall in walls if wall.crate]
    flange = description(scenario.robot)["robot"]["flange_frame"]
    housing, *palm = _hand_capsules(scenario.hand, flange)
    limits = [_limit(scenario, arm, [*arm_capsules(scenario.robot, arm), housing], [_box(wall) for wall in crates])]
    if palm:
        limits.append(_limit(scenario, arm, palm, [_rim(wall) for wall in crates]))
    return limits


def _hand_capsules(name: str, flange: str) -> list[Capsule]:
    """Return the capsules of the sensor's housing and of the rest of a hand, in the frame `flange`.

    A hand whose `robot.toml` states none gets one around the housing and one around all that does not move.
    """
    hand = Hand.load(name)
    if hand.description.collision:
        return capsules_of(hand.folder, frame=flange)
    model, found = hand.model, []
    rigid = [geom for geom in range(model.ngeom) if model.body_weldid[model.geom_bodyid[geom]] == 0]
    names = [model.geom(geom).name for geom in rigid]
    for part in (["sensor"], [other for other in names if other != "sensor"]):
        balls = outline_of(model, Pose(np.zeros(3)), part)
        if len(balls):
            found.append(Capsule(flange, *fit_capsule(balls[:, :3], balls[:, 3])))
    return found


def _limit(scenario: Scenario, arm: ArmModel, capsules: list[Capsule], boxes: list[Box]) -> CollisionLimit:
    return CollisionLimit(arm, capsules, boxes, scenario.controller.rate, margin=MARGIN, self_collision=False)


def _box(wall: Wall) -> Box:
    cosine, sine = math.cos(wall.yaw), math.sin(wall.yaw)
    rotation = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    return Box(2.0 * wall.half_size, Pose(wall.center, rotation), wall.name)


def _rim(wall: Wall) -> Box:
    box = _box(wall)
    length, width, height = box.size.tolist()
    return Box(
        np.array([length, width, RIM_HEIGHT]),
        box.pose.moved([0.0, 0.0, 0.5 * (height - RIM_HEIGHT)]),
        f"{wall.name} rim",
    )
