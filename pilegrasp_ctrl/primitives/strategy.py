"""From a point of the pile, its extent and three angles to primitives (the paper, IV and Fig. 3)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..config_sections import LineConfig, StrategyConfig
from ..types import Array, Pose
from .approach import Approach
from .grasp import Grasp
from .lift import Lift
from .move import Move
from .primitive import Primitive
from .push import Push
from .scoop import Scoop

START_HEIGHT = 0.22
START_BACK = 0.06
"""The attempt starts this far above the surface and behind the pre-grasp pose [m]."""
PRE_GRASP_HEIGHT = 0.06
HAND_HALF_WIDTH = 0.06
HAND_ROOM = 0.12
"""A gap in the pile takes the hand when it is this wide: its fingers, and the way that it begins with [m]."""
UP = np.array([0.0, 0.0, 1.0])
LIFT_SPEED = 0.12
LIFT_BACK = 0.06
"""The lift leaves the support by this much, as the authors' does by 0.05 m: straight up, an object that the fingers
press to the wall rolls along it out of the hand, and in a bin the fingers wipe over the rim [m]."""
HOLD_TIME = 1.0


@dataclass(frozen=True, slots=True)
class Tool:
    """What the strategy must know of the hand.

    Attributes:
        theta: slope of fingers or scoop against the table [rad].
        press_depth: how far the push's reference lies below touch-down [m].
        normal_force: desired force on the support [N].
        preshape: closure before the grasp.
        closing_time: [s].
        advance: farthest that the reference goes on along the push while the hand closes [m].
        scoop_angle: how far to tilt back [rad].
        heel: from the leading edge to the heel [m].
    """

    theta: float
    press_depth: float
    normal_force: float
    preshape: float
    closing_time: float
    advance: float
    scoop_angle: float
    heel: float


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """What an attempt does.

    Attributes:
        start: where the tool begins.
        primitives: in their order.
        waypoints: poses on the way that must be within reach.
        end: farthest pose of the motion, which must be within reach as well.
        closure: of the hand at the start.
        direction: (3,) of the push, along which the force is watched.
    """

    start: Pose
    primitives: tuple[Primitive, ...]
    waypoints: tuple[Pose, ...]
    end: Pose
    closure: float
    direction: Array


def tool_rotation(yaw: float, theta: float) -> Array:
    """Return the tool's rotation: fingers along `yaw`, sloping down by `theta`; x along them, z out of the palm."""
    cy, sy, ct, st = math.cos(yaw), math.sin(yaw), math.cos(theta), math.sin(theta)
    return np.array([[cy * ct, -sy, cy * st], [sy * ct, cy, sy * st], [-st, 0.0, ct]])


def pile_extent(positions: Array, radius: float, center: Array, direction: Array, room: float = HAND_ROOM) -> float:
    """Return how far the pile reaches back from its centre against the push [m], strays left out.

    Only objects in the hand's way count; and the extent ends at the first gap, seen from the centre, in which the hand
    can come down. In a narrower one it would come down on the objects behind it.

    Args:
        positions: (n, 2) of the objects' centres [m].
        radius: of an object [m].
        center: (2,) of the pile [m].
        direction: (2,) of the push.
        room: width of such a gap [m].
    """
    offset = positions - center
    lateral = np.abs(offset @ np.array([-direction[1], direction[0]]))
    back = np.sort(-offset[lateral < HAND_HALF_WIDTH + radius] @ direction)
    edge = 0.0
    for distance in back[back > 0.0]:
        if distance - edge > 2.0 * radius + room:
            break
        edge = float(distance)
    return edge + radius


def touch_point(config: StrategyConfig, center: Array, extent: float, yaw: float = 0.0) -> Array:
    """Return where the fingertips touch the table (2,) [m]: `clearance` behind the pile's edge."""
    alpha = yaw + math.radians(config.alpha_deg)
    return center - (extent + config.clearance) * np.array([math.cos(alpha), math.sin(alpha)])


def pile_strategy(
    config: StrategyConfig,
    tool: Tool,
    center: Array,
    extent: float,
    reach: float,
    grasp: bool = True,
    yaw: float = 0.0,
    arm_axis: Array | None = None,
) -> Plan:
    """Return the plan of an attempt.

    Args:
        config: angles, speed and thresholds.
        tool: the hand's numbers.
        center: (2,) what the hand aims at: the pile's centre, or one of its objects [m].
        extent: how far the pile reaches from there toward the hand [m].
        reach: farthest fingertip position from the arm's axis [m].
        grasp: whether grasp and lift follow the push.
        yaw: direction of alpha = 0 about z [rad].
        arm_axis: (2,) where the arm stands [m]; the origin where absent.
    """
    alpha = yaw + math.radians(config.alpha_deg)
    theta = tool.theta if config.theta_deg is None else math.radians(config.theta_deg)
    direction = np.array([math.cos(alpha), math.sin(alpha), 0.0])
    rotation = tool_rotation(alpha + math.radians(config.beta_deg), theta)
    touch = np.array([*touch_point(config, center, extent, yaw), 0.0])
    pre_grasp = Pose(touch + PRE_GRASP_HEIGHT * UP, rotation)
    start = Pose(touch - START_BACK * direction + START_HEIGHT * UP, rotation)
    travel = _travel(touch[:2] - (0.0 if arm_axis is None else arm_axis), direction[:2], reach)
    approach = Approach(
        pre_grasp, PRE_GRASP_HEIGHT, config.approach_speed, config.touch_speed, config.touch_force, tool.preshape
    )
    push = Push(direction, config.speed, config.grasp_force, travel, tool.press_depth, tool.normal_force, tool.preshape)
    primitives: tuple[Primitive, ...] = (approach, push)
    if grasp:
        closing = (
            Scoop(tool.scoop_angle, tool.heel, theta)
            if tool.scoop_angle > 0.0
            else Grasp(tool.closing_time, direction, config.speed, config.grasp_force, tool.advance)
        )
        primitives += (closing, Lift(config.lift_height, LIFT_SPEED, HOLD_TIME, -LIFT_BACK * direction))
    far = Pose(touch + travel * direction, rotation)
    return Plan(start, primitives, (pre_grasp, Pose(touch, rotation)), far, tool.preshape, direction)


def line_plan(config: LineConfig, tool: Tool) -> Plan:
    """Return the plan of a straight line in free space, the hand sloping as for a push along x."""
    start = Pose(np.array(config.start), tool_rotation(0.0, tool.theta))
    move = Move(np.array(config.displacement), config.speed, tool.preshape)
    return Plan(start, (move,), (), start.moved(config.displacement), tool.preshape, np.array([1.0, 0.0, 0.0]))


def _travel(start: Array, direction: Array, reach: float) -> float:
    """Return the distance from `start` along `direction` to the circle of radius `reach` about the arm's axis."""
    along = float(start @ direction)
    inside = reach**2 - float(start @ start)
    return -along + math.sqrt(max(along**2 + inside, 0.0))
