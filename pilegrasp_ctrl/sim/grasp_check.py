"""Is something in the hand? Looks at the simulated poses; the strategy never does."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..types import Array

if TYPE_CHECKING:
    # A recording is judged by the same rule, without the engine.
    import mujoco

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
    return int(np.count_nonzero(are_held(data.xpos[list(objects)], tool_position, rest_height, lift)))


def are_held(position: Array, tool_position: Array, rest_height: Array, lift: float) -> np.ndarray:
    """Return which of n objects hang in the hand (n,), from their positions (n, 3) [m]; see `held_objects`."""
    risen = position[:, 2] > rest_height + 0.5 * lift
    near = np.linalg.norm(position - tool_position, axis=1) < REACH
    return np.asarray(risen & near)
