"""The room of an arm that states none: found by searching postures of arm and hand on the table."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from ..exceptions import ModelError, UnreachablePoseError
from ..planning.arm_room import ArmRoom, stated_room
from ..planning.simulated_arm import DEFAULT_BASE_RADIUS, ArmBodies, simulated_arm
from ..planning.strategy import START_BACK, START_HEIGHT, tool_rotation
from ..robots import folder_digest
from ..sim.hand import Hand
from ..sim.start_posture import StartPosture
from ..types import Array, Pose
from ..vectors import norm, rotated

SHOULDER_ABOVE_TABLE = 0.1
"""Height of the second joint over the table's top [m]; chosen, that of the WAM on its stand."""

STEP = 0.04
"""Distance between the places on the table that are tried [m]; chosen."""

SHORTEST_PUSH = 0.2
"""Least distance from the nearest touch-down to the end of the push [m]; chosen."""

SLACK = 0.02
"""Distance kept from the nearest place that is reached [m]; chosen."""


def room_of(robot: str, hand: Hand) -> ArmRoom:
    """Return the room that an arm states, or else the one that is derived from its model and the hand.

    Raises:
        ModelError: There is no such arm, or hand and arm have no room on a table.
    """
    room = stated_room(robot)
    if room is not None:
        return room
    pose = hand.transform_tool_to_flange
    numbers = (*pose.translation.tolist(), *pose.rotation.ravel().tolist())
    return _derived(robot, folder_digest(robot), numbers, hand.theta)


def room_between(near: float, far: float, base_below_table: float, base_radius: float = DEFAULT_BASE_RADIUS) -> ArmRoom:
    """Return the room of an arm whose fingertips reach from `near` to `far` on the table [m].

    The offsets are those of the WAM, whose room was measured.
    """
    far = math.floor(100.0 * far + 1e-6) / 100.0
    near = min(math.ceil(100.0 * near - 1e-6) / 100.0 + SLACK, far - 0.14)
    lengths = {
        "base_below_table": base_below_table,
        "base_radius": base_radius,
        "min_touch_distance": near,
        "max_touch_distance": min(near + 0.06, far - 0.13),
        "push_end": far - 0.10,
        "wall_distance": far - 0.04,
        "corner_distance": far + 0.06,
    }
    reach = tuple(round(far - less, 3) for less in (0.0, 0.02, 0.04, 0.06, 0.08, 0.12))
    return ArmRoom(reach=reach, **{name: round(length, 3) for name, length in lengths.items()})


@lru_cache(maxsize=16)
def _derived(robot: str, digest: str, numbers: tuple[float, ...], theta: float) -> ArmRoom:
    height = base_below_table(robot)
    transform_tool_to_flange = Pose(np.array(numbers[:3]), np.array(numbers[3:]).reshape(3, 3))
    search = StartPosture(robot, transform_tool_to_flange, Pose(np.array([0.0, 0.0, -height])))
    reached = _reached(search, tool_rotation(0.0, theta), _longest(robot, transform_tool_to_flange))
    if not reached or reached[-1] - reached[0] < SHORTEST_PUSH:
        raise ModelError(
            f"{robot}: with this hand its fingertips reach no stretch of {SHORTEST_PUSH:g} m on a table "
            f"{1000 * height:.0f} mm above its base; state [room] and postures.search in its robot.toml, or let "
            "`pilegrasp check` find them"
        )
    return room_between(reached[0], reached[-1], height)


def base_below_table(robot: str) -> float:
    """Return how far below the table's top an arm's base stands, so that its shoulder is as high as the WAM's [m]."""
    bodies = simulated_arm(robot).source
    if not isinstance(bodies, ArmBodies) or len(bodies.bodies) < 3:
        return 0.0
    first, second = bodies.bodies[1].pose, bodies.bodies[2].pose
    shoulder = first.translation + rotated(first.rotation, second.translation)
    return max(0.0, round(float(shoulder[2]) - SHOULDER_ABOVE_TABLE, 2))


def _reached(search: StartPosture, rotation: Array, longest: float) -> list[float]:
    """Return the first unbroken stretch of places over which the hand can begin, and on which it can stand [m]."""
    reached: list[float] = []
    q: Array | None = None
    for distance in np.arange(STEP * math.ceil(0.2 * longest / STEP), longest, STEP).tolist():
        try:
            found = search.solve(Pose(np.array([distance, 0.0, 0.0]), rotation), q)
            if not reached:
                search.solve_near(Pose(np.array([distance - START_BACK, 0.0, START_HEIGHT]), rotation), found)
        except UnreachablePoseError:
            if reached:
                break
            continue
        reached.append(distance)
        q = found
    return reached


def _longest(robot: str, transform_tool_to_flange: Pose) -> float:
    """Return a bound of the fingertips' distance from the first joint's axis [m]: that of a stretched arm."""
    bodies = simulated_arm(robot).source
    if not isinstance(bodies, ArmBodies):
        return 1.2
    index, length = bodies.flange_body, norm(bodies.flange.translation) + norm(transform_tool_to_flange.translation)
    while index > 1:
        length += norm(bodies.bodies[index].pose.translation)
        index = bodies.bodies[index].parent
    return length
