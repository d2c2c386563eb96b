"""The line of a push: its point, its direction, and the extent of the pile along it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..exceptions import UnreachablePoseError
from ..sections import StrategyConfig
from ..types import Array, rotation_matrices
from ..vectors import components, inner, rotated
from .hand_use import HandUse
from .layout import Layout
from .object_choice import choose_object
from .push_goal import PushGoal
from .strategy import MIN_GAP, pile_extent, tool_rotation, touch_point
from .walls import Wall

LEAST_CLEARANCE = 0.01
"""Smallest clearance between fingertips and pile at touch-down [m]. If a bin's near wall leaves no
room for `strategy.clearance`, the hand comes down nearer to the pile, but never nearer than this; chosen."""

WALL_CLEARANCE = 0.02
"""Clearance between the hand and a wall that it passes [m]; the soft hand and the arm deflect sideways by less."""

PARALLEL = 1e-6
"""Component of a wall's inward normal along the push [-] above which the wall counts as behind the hand; rounding."""


@dataclass(frozen=True, slots=True, eq=False)
class PushLine:
    """The line of a push.

    Attributes:
        point: (2,) point on the line, at the support or in the pile [m].
        extent: Distance that the pile reaches from that point toward the hand [m].
        yaw: Direction of alpha = 0 about z [rad].
    """

    point: Array
    extent: float
    yaw: float

    def touch(self, strategy: StrategyConfig) -> Array:
        """Return the touch-down point (2,) of the fingertips on the table [m]."""
        return touch_point(strategy, self.point, self.extent, self.yaw)


def plan_push_line(
    strategy: StrategyConfig,
    hand: HandUse,
    layout: Layout,
    poses: Array,
    radius: float,
    *,
    cylinders: bool = False,
    goal: PushGoal | None = None,
) -> PushLine:
    """Return the line to the support behind the pile's middle, to a chosen object, or to a goal in a bin.

    Args:
        strategy: Angles, clearance, and the aim: the pile or an object.
        hand: Hand, whose outline must fit into a corner.
        layout: Layout with the support's walls.
        poses: (n, 7) object poses: position [m] and quaternion wxyz.
        radius: Bounding radius of an object [m].
        cylinders: Whether the objects are cylinders, which roll only across their own z axis.
        goal: Push goal; None outside a bin.

    Raises:
        UnreachablePoseError: The pile in a bin is so near to the arm that hand or arm would hit a wall.
    """
    positions, yaw = poses[:, :2], goal.yaw if goal else layout.support_error[2]
    alpha = yaw + math.radians(strategy.alpha_deg)
    direction = np.array([math.cos(alpha), math.sin(alpha)])
    middle = _pile_middle(positions, layout.frame_size) if len(positions) else layout.frame_center
    if goal:
        # The hand has less room in a bin, so the goal fixes the line, and the pile only its start.
        goal = goal.best_line(positions, hand.aim_half_width)[0]
        point = goal.anchor + min(inner(middle - goal.anchor, direction), -radius) * direction
    elif strategy.kind == "object":
        axes = rotation_matrices(poses[:, 3:])[..., 2] if cylinders else None
        point = positions[choose_object(poses[:, :3], direction, radius, middle, axes)]
    elif layout.support == "wall":
        point = _point_at_wall(layout, middle, radius)
    else:
        point = center_between_walls(layout.walls, _turned_outline(hand, strategy, yaw), direction, middle)
    # In a bin the push cannot begin far behind the pile, so a narrower gap ends the pile there.
    gap = radius if goal else MIN_GAP
    extent = (
        pile_extent(positions, radius, point, direction, hand.half_width, gap)
        if len(positions)
        else 0.5 * layout.frame_size
    )
    if goal:
        extent -= _reach_correction(goal, touch_point(strategy, point, extent, yaw), direction, strategy.clearance)
    return PushLine(point, extent, yaw)


def center_between_walls(walls: Sequence[Wall], outline: Array, direction: Array, point: Array) -> Array:
    """Return `point` (2,) [m], moved sideways onto the line on which the hand gets farthest between two walls.

    On that line both sides of the hand meet their walls at the same time. Beside a wall that runs along the push the
    hand keeps `WALL_CLEARANCE`, also if it is wider on one side, for example because of its thumb. The point does not
    move if fewer than two walls lie ahead or alongside, because then no line is better.

    Args:
        walls: Walls of the support.
        outline: (n, 4) balls that span the hand as it pushes: centre relative to the fingertips, z up, and radius [m].
        direction: (2,) unit vector of the push.
        point: (2,) point that the push would otherwise run through [m].
    """
    left = np.array([-direction[1], direction[0]])
    normals, distances = [], []
    for wall in walls:
        normal = np.array([math.cos(wall.yaw), math.sin(wall.yaw)])
        if inner(normal, direction) > PARALLEL:
            continue
        face = wall.center[:2] + wall.half_size[0] * normal
        low = outline[outline[:, 2] - outline[:, 3] < wall.center[2] + wall.half_size[2]]
        beyond = float((components(low[:, :2], normal) - low[:, 3]).min())
        normals.append((inner(left, normal), inner(direction, normal)))
        distances.append(inner(point - face, normal) + beyond - WALL_CLEARANCE)
    if len(normals) != 2:
        return point
    # Both distances are zero after a motion `aside` to the left and another one along the push; Cramer's rule.
    (a, b), (c, d) = normals
    aside = (b * distances[1] - d * distances[0]) / (a * d - b * c)
    return point + aside * left


def _point_at_wall(layout: Layout, middle: Array, radius: float) -> Array:
    """Return the centre (2,) of an object at the wall, straight ahead of the pile's middle [m]."""
    x, y, turn = layout.support_error
    if turn == 0.0:
        return np.array([layout.support_distance + x - radius, middle[1]])
    ahead = np.array([math.cos(turn), math.sin(turn)])
    face = np.array([layout.support_distance + x, y])
    return middle + (inner(face - middle, ahead) - radius) * ahead


def _pile_middle(positions: Array, size: float) -> Array:
    """Return the centroid (2,) of the pile, without strays that lie `size` [m] or farther from the median.

    The median itself would not do: with an odd number of columns of balls it lies on a ball. The side walls of the
    shovel would then hit the two balls beside it.
    """
    off = np.linalg.norm(positions - np.median(positions, axis=0), axis=1)
    near = off < size
    # If two objects lie far apart, neither is near the median. One of them then counts as the pile.
    near[off.argmin()] = True
    return positions[near].mean(axis=0)


def _reach_correction(goal: PushGoal, touch: Array, direction: Array, clearance: float) -> float:
    """Return how much nearer to the pile than `touch` (2,) the hand must touch down for the wrist to have room [m]."""
    deficit = goal.reach_deficit(touch, direction)
    if deficit > max(0.0, clearance - LEAST_CLEARANCE):
        raise UnreachablePoseError(
            f"the pile in front of {goal.name} is {1000 * deficit:.0f} mm too near to the arm: "
            "hand or arm would hit a wall of the bin; lower pile.count"
        )
    return deficit


def _turned_outline(hand: HandUse, strategy: StrategyConfig, yaw: float) -> Array:
    """Return the hand's outline (n, 4) as it pushes, seen from the fingertips in the axes of the world [m].

    Args:
        hand: Hand.
        strategy: Angles.
        yaw: Direction of alpha = 0 about z [rad].
    """
    outline = hand.outline.copy()
    yaw += math.radians(strategy.alpha_deg + strategy.beta_deg)
    theta = hand.theta if strategy.theta_deg is None else math.radians(strategy.theta_deg)
    outline[:, :3] = rotated(tool_rotation(yaw, theta), outline[:, :3])
    return outline
