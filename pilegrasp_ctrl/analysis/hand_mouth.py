"""The leading edge of the hand, from the recorded shapes, and the side on which a wall is nearer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..recording import Recording
from ..types import Array, rotation_matrices
from ..vectors import product, rotated

MIN_SLANT = 0.17
"""Least component of a slanted wall's normal along the hand, and across it [-]: the sine of 10°, chosen."""


@dataclass(frozen=True, slots=True)
class HandMouth:
    """Outline of the hand in its own frame, whose origin is the tool; all values are in metres.

    Attributes:
        front: Position of the leading edge along x. The hand lies beneath an object whose centre is behind it.
        rear: Position of the rearmost point along x.
        right: Right end of the leading edge (smallest y).
        left: Left end of the leading edge (largest y).
    """

    front: float
    rear: float
    right: float
    left: float

    @property
    def width(self) -> float:
        """Width of the leading edge [m]."""
        return self.left - self.right

    @classmethod
    def of(cls, recording: Recording, frames: slice, tool: Array, axes: Array, depth: float) -> HandMouth | None:
        """Return the median outline over some frames, or None if no hand was recorded.

        Args:
            recording: The attempt.
            frames: Frames to look at.
            tool: (F, 3) positions of the tool in those frames [m].
            axes: (2, 3) level unit vectors along the fingers and to the hand's left.
            depth: Distance from the foremost and from the lowest point within which a shape belongs to the leading edge
                [m]. A thumb above the objects does not belong to it.
        """
        upright = np.vstack([axes, [0.0, 0.0, 1.0]])
        center, extent = _hand_boxes(recording, frames, upright)
        if not center.shape[1]:
            return None
        center = center - rotated(upright, tool)[:, None]
        high, low = center + extent, center - extent
        sliding = low[..., 2] < low[..., 2].min(axis=1, keepdims=True) + depth
        front = np.where(sliding, high[..., 0], -np.inf).max(axis=1)
        leading = sliding & (high[..., 0] > front[:, None] - depth)
        right = np.where(leading, low[..., 1], np.inf).min(axis=1)
        left = np.where(leading, high[..., 1], -np.inf).max(axis=1)
        return cls(*(float(np.median(line)) for line in (front, low[..., 0].min(axis=1), right, left)))


def nearer_side(recording: Recording, axes: Array) -> int:
    """Return 1 if the walls ahead of the hand are nearer on its left, -1 on its right, 0 on neither side.

    Neither side is nearer if the walls are square to the hand, or in a corner, whose walls slant to both sides.

    Args:
        recording: The attempt. An upright box of a support counts as a wall.
        axes: (2, 3) level unit vectors along the fingers and to the hand's left.
    """
    sides = set()
    for index, body in enumerate(recording.bodies):
        if body.role != "support":
            continue
        turn = rotation_matrices(recording.body_quaternion[0, index])
        for shape in body.shapes:
            if shape.kind != "box":
                continue
            normal = product(turn, rotation_matrices(shape.quaternion))[:, np.argmin(shape.half_extents())]
            x, y = rotated(axes, normal)
            if abs(x) > MIN_SLANT:
                sides.add(int(np.sign(x * y)) if abs(y) > MIN_SLANT else 0)
    return sides.pop() if len(sides) == 1 else 0


def _hand_boxes(recording: Recording, frames: slice, axes: Array) -> tuple[Array, Array]:
    """Return centres and half-extents (F, shapes, 3) of the hand's shapes along three axes [m]."""
    centers, extents = [], []
    for index, body in enumerate(recording.bodies):
        if body.role != "hand":
            continue
        turn = rotation_matrices(recording.body_quaternion[frames, index])
        place = recording.body_position[frames, index].astype(float)
        for shape in body.shapes:
            centers.append(rotated(axes, place + rotated(turn, shape.position)))
            turned = product(product(axes, turn), rotation_matrices(shape.quaternion))
            extents.append(rotated(np.abs(turned), shape.half_extents()))
    if not centers:
        return np.zeros((0, 0, 3)), np.zeros((0, 0, 3))
    return np.stack(centers, axis=1), np.stack(extents, axis=1)
