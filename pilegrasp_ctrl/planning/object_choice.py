"""The object-based strategy: choose the object of a pile that the hand aims at (the paper, V-B). Pure geometry."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..types import Array
from ..vectors import components, inner, norm

TOUCHING_DISTANCE = 1.15
"""Distance of two centres up to which objects count as touching, in diameters [-]; chosen."""

LAYER_HEIGHT = 1.0
"""Height over the lowest object from which an object lies on others, in radii [-]; chosen.

The hand cannot push such an object."""

UPRIGHT = math.cos(math.radians(20.0))
"""Least vertical part of the axis of an upright cylinder [-]: it is within 20° of the vertical; chosen."""

BROADSIDE = math.sin(math.radians(30.0))
"""Greatest part of a broadside cylinder's axis along the push, and along the vertical [-]: 30° off square; chosen."""


def choose_object(positions: Array, direction: Array, radius: float, center: Array, axes: Array | None = None) -> int:
    """Return the object to aim at: the one that a straight push moves most nearly toward the pile's centre.

    The hand can choose among the objects that it would meet first. Cylinders that are upright, or that turn
    their curved surface to the hand, are preferred. A pushed object moves straight ahead, or slides along the object
    ahead that it touches. The choice is the object whose direction of motion points most nearly at the centre.

    Args:
        positions: (n, 3) object centres [m], n > 0.
        direction: (2,) unit vector of the push.
        radius: Object radius [m].
        center: (2,) centre of the pile [m].
        axes: (n, 3) axes of cylinders; None for objects that look the same from all sides.
    """
    plane = positions[:, :2]
    candidates = _front_objects(positions, direction, radius)
    if axes is not None:
        preferred = candidates[_is_upright_or_broadside(axes[candidates], direction)]
        candidates = preferred if len(preferred) else candidates
    return int(max(candidates, key=lambda index: _alignment(plane, index, direction, radius, center)))


def _front_objects(positions: Array, direction: Array, radius: float) -> NDArray[Any]:
    """Return the indices of the objects in the lowest layer that no other object shields from the hand."""
    low = np.flatnonzero(positions[:, 2] < positions[:, 2].min() + LAYER_HEIGHT * radius)
    plane = positions[low, :2]
    left = np.array([-direction[1], direction[0]])
    along, aside = components(plane, direction), components(plane, left)
    nearer = along[None, :] < along[:, None] - 1e-9
    overlapping = np.abs(aside[None, :] - aside[:, None]) < radius
    return low[~(nearer & overlapping).any(axis=1)]


def _is_upright_or_broadside(axes: Array, direction: Array) -> NDArray[np.bool]:
    """Return which cylinders with axes (n, 3) are upright, or turn their curved surface to the hand."""
    upright = np.abs(axes[:, 2]) > UPRIGHT
    broadside = (np.abs(components(axes[:, :2], direction)) < BROADSIDE) & (np.abs(axes[:, 2]) < BROADSIDE)
    either: NDArray[np.bool] = upright | broadside
    return either


def _alignment(plane: Array, index: int, direction: Array, radius: float, center: Array) -> float:
    """Return the cosine between an object's motion and the direction from it to the pile's centre; -1 at the centre."""
    motion = _motion_direction(plane, index, direction, radius)
    to_center = center - plane[index]
    distance = norm(to_center)
    return inner(motion, to_center) / distance if distance > 1e-9 else -1.0


def _motion_direction(plane: Array, index: int, direction: Array, radius: float) -> Array:
    """Return the unit vector (2,) along which an object moves: the push, or along the nearest object that it meets."""
    offset = np.delete(plane, index, axis=0) - plane[index]
    distance = np.linalg.norm(offset, axis=1)
    met = (distance < 2.0 * TOUCHING_DISTANCE * radius) & (distance > 1e-9) & (components(offset, direction) > 1e-9)
    if not met.any():
        return direction
    normal = offset[met][np.argmin(distance[met])]
    normal = normal / norm(normal)
    slide = direction - inner(direction, normal) * normal
    length = norm(slide)
    return slide / length if length > 1e-6 else direction
