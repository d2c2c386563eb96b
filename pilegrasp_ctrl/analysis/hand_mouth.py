"""The hand as the pile meets it: its leading edge and how wide that is, from the recorded shapes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..recording import Recording
from ..types import Array, rotation_matrices


@dataclass(frozen=True, slots=True)
class HandMouth:
    """Lines of the hand's frame with its origin at the tool, all in metres.

    Attributes:
        front: of the leading edge along x; an object whose centre lies behind it has the hand beneath it.
        rear: where the hand ends against x.
        right: where the leading edge ends to the right (smallest y).
        left: where it ends to the left (largest y).
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
        """Return the median over some frames, or None where no hand was recorded.

        Args:
            recording: the attempt.
            frames: over which to look.
            tool: (F, 3) positions of the tool in those frames [m].
            axes: (2, 3) level unit vectors where the hand points and to its left.
            depth: shapes that reach within this of the foremost point, and of the lowest, make up the leading edge [m];
                a thumb above the objects is no part of it.
        """
        upright = np.vstack([axes, [0.0, 0.0, 1.0]])
        center, extent = _hand_boxes(recording, frames, upright)
        if not center.shape[1]:
            return None
        center = center - (tool @ upright.T)[:, None]
        high, low = center + extent, center - extent
        sliding = low[..., 2] < low[..., 2].min(axis=1, keepdims=True) + depth
        front = np.where(sliding, high[..., 0], -np.inf).max(axis=1)
        leading = sliding & (high[..., 0] > front[:, None] - depth)
        right = np.where(leading, low[..., 1], np.inf).min(axis=1)
        left = np.where(leading, high[..., 1], -np.inf).max(axis=1)
        return cls(*(float(np.median(line)) for line in (front, low[..., 0].min(axis=1), right, left)))


def _hand_boxes(recording: Recording, frames: slice, axes: Array) -> tuple[Array, Array]:
    """Return centres and half-extents (F, shapes, 3) of the hand's shapes along three axes."""
    centers, extents = [], []
    for index, body in enumerate(recording.bodies):
        if body.role != "hand":
            continue
        turn = rotation_matrices(recording.body_quaternion[frames, index])
        place = recording.body_position[frames, index].astype(float)
        for shape in body.shapes:
            centers.append((place + turn @ np.array(shape.position)) @ axes.T)
            own = axes @ turn @ rotation_matrices(shape.quaternion)
            extents.append(np.abs(own) @ np.array(shape.half_extents()))
    if not centers:
        return np.zeros((0, 0, 3)), np.zeros((0, 0, 3))
    return np.stack(centers, axis=1), np.stack(extents, axis=1)
