"""The plan of an attempt: from a push line and three angles to primitives (the paper, IV and Fig. 3)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..primitives.free_motions import Lift, Move
from ..primitives.grasp import Grasp, Scoop
from ..primitives.guarded_motions import Approach, Push
from ..primitives.primitive import UP, Primitive
from ..primitives.push_endings import PUSH_ENDINGS
from ..primitives.retry import Composite
from ..sections import LineConfig, StrategyConfig
from ..types import Array, Pose
from ..vectors import components, inner
from .hand_use import HandUse
from .layout import START_HEIGHT

START_BACK = 0.06
"""Distance from the pre-grasp pose back to the start, against the push [m]; chosen."""

PRE_GRASP_HEIGHT = 0.06
"""Height of the fingertips over the surface at which the hand begins to lower onto the table [m]; chosen."""

MIN_GAP = 0.12
"""Least width of a gap in the pile in which the hand can come down [m]: its fingers and the start of its push."""

LIFT_SPEED = 0.12
"""Speed of the lift [m/s]; chosen."""

LIFT_BACK = 0.06
"""Distance by which the lift first moves away from the support [m]; chosen. The authors' lift moves 0.05 m away.

On a straight lift, an object between fingers and wall rolls along the wall out of the hand. In a bin, the fingers
would also wipe over the rim."""

HOLD_TIME = 1.0
"""Time for which the hand holds the objects before the attempt is judged [s]; the paper's hold."""


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """Plan of an attempt.

    Attributes:
        start: Pose of the tool at the start.
        primitives: Primitives in their order; some may be composites, such as a `Retry`.
        waypoints: Intermediate poses that must be within reach.
        end: Farthest pose of the motion, which must be within reach as well.
        closure: Closure of the hand at the start.
        direction: (3,) unit vector of the push, along which the force is watched.
        grasps: Whether an object must be in the hand at the end.
    """

    start: Pose
    primitives: tuple[Primitive | Composite, ...]
    waypoints: tuple[Pose, ...]
    end: Pose
    closure: float
    direction: Array
    grasps: bool = True


def tool_rotation(yaw: float, theta: float) -> Array:
    """Return the tool's rotation: fingers along `yaw`, sloping down by `theta`; x along them, z out of the palm."""
    cy, sy, ct, st = math.cos(yaw), math.sin(yaw), math.cos(theta), math.sin(theta)
    return np.array([[cy * ct, -sy, cy * st], [sy * ct, cy, sy * st], [-st, 0.0, ct]])


def pile_extent(
    positions: Array, radius: float, center: Array, direction: Array, half_width: float, gap: float = MIN_GAP
) -> float:
    """Return the extent of the pile from its centre back toward the hand [m], without strays.

    Only objects that the hand meets count. Seen from the centre, the extent ends at the first gap in which the hand can
    come down. In a narrower gap it would come down on the objects behind it.

    Args:
        positions: (n, 2) object centres [m].
        radius: Object radius [m].
        center: (2,) centre of the pile [m].
        direction: (2,) unit vector of the push.
        half_width: Half the width in which the hand meets objects [m].
        gap: Least width of such a gap [m].
    """
    offset = positions - center
    lateral = np.abs(components(offset, (-direction[1], direction[0])))
    back = np.sort(-components(offset[lateral < half_width + radius], direction))
    edge = 0.0
    for distance in back[back > 0.0]:
        if distance - edge > 2.0 * radius + gap:
            break
        edge = float(distance)
    return edge + radius


def touch_point(config: StrategyConfig, center: Array, extent: float, yaw: float = 0.0) -> Array:
    """Return the touch-down point (2,) of the fingertips [m]: `clearance` behind the pile's edge."""
    alpha = yaw + math.radians(config.alpha_deg)
    return center - (extent + config.clearance) * np.array([math.cos(alpha), math.sin(alpha)])


def plan_attempt(
    config: StrategyConfig,
    hand: HandUse,
    center: Array,
    extent: float,
    reach: float,
    grasp: bool = True,
    yaw: float = 0.0,
    base_position: Array | None = None,
    start_height: float = START_HEIGHT,
) -> Plan:
    """Return the plan of an attempt.

    Args:
        config: Angles, speed and thresholds.
        hand: Use of the hand.
        center: (2,) point that the hand aims at: the pile's centre, or one of its objects [m].
        extent: Distance that the pile reaches from there toward the hand [m].
        reach: Farthest fingertip distance from the arm's axis [m].
        grasp: Whether grasp and lift follow the push.
        yaw: Direction of alpha = 0 about z [rad].
        base_position: (2,) position of the arm's base [m]; the origin if absent.
        start_height: Height of the fingertips over the surface at the start [m].
    """
    alpha = yaw + math.radians(config.alpha_deg)
    theta = hand.theta if config.theta_deg is None else math.radians(config.theta_deg)
    direction = np.array([math.cos(alpha), math.sin(alpha), 0.0])
    rotation = tool_rotation(alpha + math.radians(config.beta_deg), theta)
    touch = np.array([*touch_point(config, center, extent, yaw), 0.0])
    pre_grasp = Pose(touch + PRE_GRASP_HEIGHT * UP, rotation)
    start = Pose(touch - START_BACK * direction + start_height * UP, rotation)
    travel = _travel(touch[:2] - (0.0 if base_position is None else base_position), direction[:2], reach)
    approach = Approach(
        pre_grasp, PRE_GRASP_HEIGHT, config.approach_speed, config.touch_speed, config.touch_force, hand.preshape
    )
    endings = PUSH_ENDINGS[config.close_on]
    push = Push(
        direction,
        config.speed,
        config.grasp_force,
        travel,
        hand.press_depth,
        hand.normal_force,
        hand.preshape,
        endings,
    )
    primitives: tuple[Primitive, ...] = (approach, push)
    if grasp:
        if hand.closes:
            # An event before F_grasp finds a force near zero.
            begun = 0.0 if endings else None
            primitives += (Grasp(hand.closing_time, direction, config.speed, config.grasp_force, hand.advance, begun),)
        elif hand.scoop_angle > 0.0:
            primitives += (Scoop(hand.scoop_angle, hand.heel, theta),)
        primitives += (Lift(config.lift_height, LIFT_SPEED, HOLD_TIME, -LIFT_BACK * direction),)
    far = Pose(touch + travel * direction, rotation)
    return Plan(start, primitives, (pre_grasp, Pose(touch, rotation)), far, hand.preshape, direction, grasp)


def plan_line(config: LineConfig, hand: HandUse) -> Plan:
    """Return the plan of a straight line in free space. The hand is inclined as for a push along x."""
    start = Pose(np.array(config.start), tool_rotation(0.0, hand.theta))
    move = Move(np.array(config.displacement), config.speed, hand.preshape)
    return Plan(start, (move,), (), start.moved(config.displacement), hand.preshape, np.array([1.0, 0.0, 0.0]), False)


def _travel(start: Array, direction: Array, reach: float) -> float:
    """Return the distance from `start` along `direction` to the circle of radius `reach` about the arm's axis."""
    along = inner(start, direction)
    inside = reach**2 - inner(start, start)
    return -along + math.sqrt(max(along**2 + inside, 0.0))
