"""The rule that decides "held": which objects hang in the hand after the lift. The strategy never asks it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..types import Array

REACH = 0.20
"""Largest distance of a held object's centre from the tool frame's origin [m]; the hand is 0.18 m long."""

RISEN = 0.5
"""Share of the lift that an object must have risen by to count as held."""

NOTHING_HELD = "nothing was in the hand after the lift"
"""Reason of an attempt after whose lift no object is held."""


def are_held(position: Array, tool_position: Array, rest_height: Array, lift: float) -> NDArray[np.bool_]:
    """Return which of n objects hang in the hand (n,).

    Args:
        position: (n, 3) object centres after the lift and the hold [m].
        tool_position: (3,) origin of the tool frame [m].
        rest_height: (n,) heights of the object centres before the attempt [m].
        lift: Height of the lift [m].
    """
    risen = position[:, 2] > rest_height + RISEN * lift
    near = np.linalg.norm(position - tool_position, axis=1) < REACH
    return np.asarray(risen & near)
