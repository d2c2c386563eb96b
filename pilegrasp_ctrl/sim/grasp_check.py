"""Is something in the hand? Looks at the simulated poses; the strategy never does."""

from __future__ import annotations

import mujoco
import numpy as np

from ..types import Array

REACH = 0.20
"""A held object's centre is this near to the tool frame's origin [m]: the hand is 0.18 m long."""


def held_objects(
    data: mujoco.MjData, objects: tuple[int, ...], tool_position: Array, rest_height: Array, lift: float
) -> int:
    """Count the objects that hang in the hand.

    Args:
        data: the simulation after the lift and the hold.
        objects: body ids.
        tool_position: (3,) of the tool frame in the world [m].
        rest_height: (n,) of the objects' centres before the attempt [m].
        lift: height of the lift [m]; an object counts that rose by half of it.
    """
    if not objects:
        return 0
    position = data.xpos[list(objects)]
    risen = position[:, 2] > rest_height + 0.5 * lift
    near = np.linalg.norm(position - tool_position, axis=1) < REACH
    return int(np.count_nonzero(risen & near))
