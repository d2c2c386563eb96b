"""Which line a push into a corner takes, so that the whole hand finds room between the walls. Pure geometry."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..types import Array
from .wall import Wall

CLEARANCE = 0.02
"""Between the hand and a wall that it passes [m]; soft hand and arm give way sideways by less."""

PARALLEL = 1e-6
"""A wall runs along the push where its normal and the push have a smaller product."""


def line_between(walls: Sequence[Wall], outline: Array, direction: Array, point: Array) -> Array:
    """Return `point` (2,) [m], moved sideways onto the line on which the hand gets farthest between two walls.

    On that line both sides of the hand meet their walls at the same time; beside a wall that runs along the push the
    hand keeps `CLEARANCE`. A hand that sticks out to one side, as by its thumb, so has its room there. Where fewer than
    two walls lie ahead or alongside, no line is better than another, and the point stays.

    Args:
        walls: of the support.
        outline: (n, 4) balls that span the hand: middle as seen from the fingertips [m], with z up and the hand turned
            as it pushes, and radius [m].
        direction: (2,) of the push, a unit vector.
        point: (2,) that the push would else run through [m].
    """
    left = np.array([-direction[1], direction[0]])
    rows, room = [], []
    for wall in walls:
        normal = np.array([math.cos(wall.yaw), math.sin(wall.yaw)])
        if normal @ direction > PARALLEL:
            continue
        face = wall.center[:2] + wall.half_size[0] * normal
        low = outline[outline[:, 2] - outline[:, 3] < wall.center[2] + wall.half_size[2]]
        beyond = float((low[:, :2] @ normal - low[:, 3]).min())
        rows.append([left @ normal, direction @ normal])
        room.append((point - face) @ normal + beyond - CLEARANCE)
    if len(rows) != 2:
        return point
    aside, _ = np.linalg.solve(rows, -np.array(room))
    return point + aside * left
