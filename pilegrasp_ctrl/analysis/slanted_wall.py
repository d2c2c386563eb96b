"""On which side of the hand a wall that it meets at an angle is nearer, from the recorded shapes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..recording import Recording
from ..types import rotation_matrices

OBLIQUE = 0.17
"""Sine of 10°: a wall that is nearer than this to square before the hand, or to its way, is not slanted."""


def nearer_side(recording: Recording, axes: NDArray[np.float64]) -> int:
    """Return 1 where the walls across the hand's way are nearer on its left, -1 on its right, 0 on neither.

    It is neither where the hand meets them square, and in a corner, whose walls slant to both sides.

    Args:
        recording: the attempt; a wall is an upright box of a support.
        axes: (2, 3) level unit vectors where the hand points and to its left.
    """
    sides = set()
    for index, body in enumerate(recording.bodies):
        if body.role != "support":
            continue
        turn = rotation_matrices(recording.body_quaternion[0, index])
        for shape in body.shapes:
            if shape.kind != "box":
                continue
            normal = (turn @ rotation_matrices(shape.quaternion))[:, np.argmin(shape.half_extents())]
            x, y = axes @ normal
            if abs(x) > OBLIQUE:
                sides.add(int(np.sign(x * y)) if abs(y) > OBLIQUE else 0)
    return sides.pop() if len(sides) == 1 else 0
