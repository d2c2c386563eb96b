"""The object-based strategy: which object of a pile the hand aims at (the paper, V-B). Pure geometry on the poses."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..types import Array

TOUCHING = 1.15
"""Two objects touch that are nearer than this many diameters."""
UPPER_LAYER = 1.0
"""An object higher than the lowest by more than this many radii lies on others, and the hand cannot push it."""
UPRIGHT = math.cos(math.radians(20.0))
BROADSIDE = math.sin(math.radians(30.0))
"""A cylinder stands within 20° of the vertical, and lies broadside within 30° of square to the push."""


def choose_object(positions: Array, direction: Array, radius: float, center: Array, axes: Array | None = None) -> int:
    """Return the object to aim at: one that moves toward the pile's centre when it is pushed straight.

    The hand can choose among the objects that it would meet first. Of cylinders it takes those that stand on their base
    or turn their curved surface to the hand, where there are any. Pushed, an object goes straight until it slides along
    the one ahead that it touches; the choice is the object whose way then points most nearly at the centre.

    Args:
        positions: (n, 3) of the objects' centres [m], n > 0.
        direction: (2,) of the push.
        radius: of an object [m].
        center: (2,) of the pile [m].
        axes: (n, 3) of cylinders; None for objects that look the same from everywhere.
    """
    plane = positions[:, :2]
    chosen = _met_first(positions, direction, radius)
    if axes is not None:
        rolling = chosen[_stands_or_lies_broadside(axes[chosen], direction)]
        chosen = rolling if len(rolling) else chosen
    return int(max(chosen, key=lambda index: _aim(plane, index, direction, radius, center)))


def _met_first(positions: Array, direction: Array, radius: float) -> NDArray[Any]:
    """Return the indices of the objects in the lowest layer that no other one shields from the hand."""
    low = np.flatnonzero(positions[:, 2] < positions[:, 2].min() + UPPER_LAYER * radius)
    plane = positions[low, :2]
    along, aside = plane @ direction, plane @ _left(direction)
    nearer = along[None, :] < along[:, None] - 1e-9
    in_the_way = np.abs(aside[None, :] - aside[:, None]) < radius
    return low[~(nearer & in_the_way).any(axis=1)]


def _stands_or_lies_broadside(axes: Array, direction: Array) -> NDArray[np.bool]:
    upright = np.abs(axes[:, 2]) > UPRIGHT
    broadside = (np.abs(axes[:, :2] @ direction) < BROADSIDE) & (np.abs(axes[:, 2]) < BROADSIDE)
    either: NDArray[np.bool] = upright | broadside
    return either


def _aim(plane: Array, index: int, direction: Array, radius: float, center: Array) -> float:
    """Return the cosine between the pushed object's way and the bearing of the pile's centre; -1 behind or at it."""
    way = _way(plane, index, direction, radius)
    bearing = center - plane[index]
    distance = float(np.linalg.norm(bearing))
    return float(way @ bearing) / distance if distance > 1e-9 else -1.0


def _way(plane: Array, index: int, direction: Array, radius: float) -> Array:
    """Return where an object goes (2,), unit length: straight, or along the nearest one ahead that it touches."""
    offset = np.delete(plane, index, axis=0) - plane[index]
    distance = np.linalg.norm(offset, axis=1)
    ahead = (distance < 2.0 * TOUCHING * radius) & (distance > 1e-9) & (offset @ direction > 1e-9)
    if not ahead.any():
        return direction
    normal = offset[ahead][np.argmin(distance[ahead])]
    normal = normal / np.linalg.norm(normal)
    slid = direction - (direction @ normal) * normal
    length = float(np.linalg.norm(slid))
    return slid / length if length > 1e-6 else direction


def _left(direction: Array) -> Array:
    return np.array([-direction[1], direction[0]])
