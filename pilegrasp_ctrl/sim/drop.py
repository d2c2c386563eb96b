"""Where objects hang before they are dropped: random, above the frame's floor, and clear of one another."""

from __future__ import annotations

import math

import numpy as np

from ..exceptions import PileError
from ..planning.layout import Layout
from ..types import Array
from .objects import Objects

FRAME_HEIGHT = 0.8
"""Of the dropping frame [m]: 200 tennis balls hang in it above a floor of 0.25 m."""
SPACINGS = (2.08, 2.02)
"""Of the grid that objects drop from, over their bounding radius; the second where the first leaves no room."""


def drop_poses(kind: Objects, count: int, layout: Layout, rng: np.random.Generator) -> Array:
    """Return random poses (count, 7) above the frame's floor that do not overlap: a jittered grid, layer on layer.

    The objects of a net are dropped together, upright and side by side; whatever stands alone falls as it likes.
    """
    if kind.net is None:
        return _grid(kind.bounding_radius, count, layout, rng)
    radius = max(kind.net.ring_radius(kind.flank_radius) + kind.flank_radius, kind.bounding_radius)
    if 2.0 * radius > layout.frame_size:
        raise PileError(
            f"{kind.net.members} tied objects need {2000 * radius:.0f} mm side by side and do not fit into the frame "
            f"of {1000 * layout.frame_size:.0f} mm; raise pile.frame_size or lower pile.scale"
        )
    bags = _grid(radius, count // kind.net.members, layout, rng)
    yaw = rng.uniform(-math.pi, math.pi, size=len(bags))
    bags[:, 3:] = np.stack([np.cos(yaw / 2.0), 0.0 * yaw, 0.0 * yaw, np.sin(yaw / 2.0)], axis=-1)
    return kind.net.spread(bags, kind.flank_radius)


def _grid(radius: float, count: int, layout: Layout, rng: np.random.Generator) -> Array:
    """Return random poses (count, 7) of balls of `radius` [m]."""
    for spacing in SPACINGS:
        cell = spacing * radius
        per_side = max(1, int(layout.frame_size // cell))
        layers = math.ceil(count / per_side**2)
        if layers * cell <= FRAME_HEIGHT:
            break
    else:
        raise PileError(
            f"{count} objects need {layers} layers of {1000 * cell:.0f} mm and overflow the frame's height of "
            f"{1000 * FRAME_HEIGHT:.0f} mm; lower pile.count or raise pile.frame_size"
        )
    pitch = layout.frame_size / per_side
    slack = max(0.0, 0.5 * pitch - 1.02 * radius)
    cosine, sine = math.cos(layout.frame_yaw), math.sin(layout.frame_yaw)
    poses = np.zeros((count, 7))
    for layer in range(layers):
        cells = rng.permutation(per_side**2)
        for k in range(per_side**2):
            index = layer * per_side**2 + k
            if index >= count:
                break
            row, column = divmod(int(cells[k]), per_side)
            x = (row + 0.5) * pitch - 0.5 * layout.frame_size + rng.uniform(-slack, slack)
            y = (column + 0.5) * pitch - 0.5 * layout.frame_size + rng.uniform(-slack, slack)
            poses[index, :2] = layout.frame_center + np.array([cosine * x - sine * y, sine * x + cosine * y])
            poses[index, 2] = (layer + 0.5) * cell
            quaternion = rng.normal(size=4)
            # Summed in order: BLAS, behind numpy's norm, rounds differently from one processor to another.
            poses[index, 3:] = quaternion / math.sqrt(sum(part * part for part in quaternion.tolist()))
    return poses
