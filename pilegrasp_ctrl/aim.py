"""Where an attempt aims: the line of its push, and where on it the pile begins."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from .config_sections import StrategyConfig
from .exceptions import UnreachablePoseError
from .primitives.object_choice import choose_object
from .primitives.strategy import HAND_HALF_WIDTH, HAND_ROOM, pile_extent, tool_rotation, touch_point
from .sim.hand import Hand
from .sim.layout import Layout
from .sim.object_mix import Objects
from .sim.push_goal import PushGoal
from .sim.push_line import line_between
from .types import Array

LEAST_CLEARANCE = 0.01
"""Where the near wall leaves no room for `strategy.clearance` the hand comes down nearer to the pile, but not nearer
than this [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Aim:
    """The line of a push.

    Attributes:
        point: (2,) on it, at the support or in the pile [m].
        extent: how far the pile reaches from there toward the hand [m].
        yaw: direction of alpha = 0 about z [rad].
    """

    point: Array
    extent: float
    yaw: float

    @classmethod
    def at(
        cls, strategy: StrategyConfig, hand: Hand, layout: Layout, kind: Objects, poses: Array, goal: PushGoal | None
    ) -> Self:
        """Aim at the support behind the pile's middle, at a chosen object, or in a bin at its goal.

        Args:
            strategy: angles, clearance, and what to aim at.
            hand: whose outline must find room.
            layout: with the support's walls.
            kind: of the objects.
            poses: (n, 7) of the objects: position [m] and quaternion wxyz.
            goal: in a bin; None elsewhere.

        Raises:
            UnreachablePoseError: where the pile in a bin leaves the wrist no room.
        """
        positions, radius, yaw = poses[:, :2], kind.bounding_radius, goal.yaw if goal else 0.0
        alpha = yaw + np.radians(strategy.alpha_deg)
        direction = np.array([np.cos(alpha), np.sin(alpha)])
        middle = _middle(positions, layout.frame_size) if len(positions) else layout.frame_center
        if goal:
            # The bin leaves the hand less room than an open table: its line is the goal's, its start the pile's.
            foot = goal.lane(positions, HAND_HALF_WIDTH)[0].foot
            point = foot + min((middle - foot) @ direction, -radius) * direction
        elif strategy.kind == "object":
            axes = _axes(poses[:, 3:]) if kind.shape == "cylinder" else None
            point = positions[choose_object(poses[:, :3], direction, radius, middle, axes)]
        elif layout.kind == "wall":
            point = np.array([layout.foot - radius, middle[1]])
        else:
            point = line_between(layout.walls, _turned(hand, strategy), direction, middle)
        # A bin has no way to begin farther back.
        room = radius if goal else HAND_ROOM
        extent = pile_extent(positions, radius, point, direction, room) if len(positions) else 0.5 * layout.frame_size
        if goal:
            extent -= _moved_in(goal, touch_point(strategy, point, extent, yaw), strategy.clearance)
        return cls(point, extent, yaw)

    def touch(self, strategy: StrategyConfig) -> Array:
        """Return where the fingertips touch the table (2,) [m]."""
        return touch_point(strategy, self.point, self.extent, self.yaw)


def _middle(positions: Array, size: float) -> Array:
    """Return the centroid (2,) of the pile, without strays that lie `size` [m] or farther from the median.

    The median itself would not do: of an odd number of balls in columns it lies on one of them, and the shovel's side
    walls then meet the two beside it head-on.
    """
    off = np.linalg.norm(positions - np.median(positions, axis=0), axis=1)
    near = off < size
    # Of two objects far apart neither lies near the median; the pile is one of them then.
    near[off.argmin()] = True
    return positions[near].mean(axis=0)


def _moved_in(goal: PushGoal, touch: Array, clearance: float) -> float:
    """Return by how much the hand comes down nearer to the pile than at `touch` (2,), for the wrist's sake [m]."""
    lacking = goal.lacking(touch)
    if lacking > max(0.0, clearance - LEAST_CLEARANCE):
        raise UnreachablePoseError(
            f"the pile before {goal.name} reaches so near to the arm that the wrist would hit the bin's near wall "
            f"({1000 * lacking:.0f} mm of room are missing); lower pile.count"
        )
    return lacking


def _turned(hand: Hand, strategy: StrategyConfig) -> Array:
    """Return the hand's outline (n, 4) as it pushes, seen from the fingertips in the axes of the world [m]."""
    outline = hand.outline()
    yaw = np.radians(strategy.alpha_deg + strategy.beta_deg)
    theta = hand.theta if strategy.theta_deg is None else np.radians(strategy.theta_deg)
    outline[:, :3] = outline[:, :3] @ tool_rotation(yaw, theta).T
    return outline


def _axes(quaternions: Array) -> Array:
    """Return the directions of the objects' own z axes (n, 3); quaternions (n, 4) are wxyz."""
    w, x, y, z = quaternions.T
    return np.stack([2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)], axis=-1)
