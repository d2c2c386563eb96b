"""Layout of the scene: arm base, table, walls, bin and the frame that the pile is dropped into. Pure geometry."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ..exceptions import PileError
from ..sections import PileConfig, SupportConfig
from ..types import STANDARD_GRAVITY, Array, Pose
from .push_goal import PushGoal
from .walls import BIN_INNER, ORDER_CENTER, ORDER_INNER, Wall, make_crate_walls

Support = Literal["none", "wall", "corner"]

BASE_BELOW_TABLE = 0.25
"""Height of the table top above the arm's base [m]. Here the wrist has room and the joints have margin."""

WALL_DISTANCE = 1.0
"""Distance from the arm's axis to the wall, along the push of alpha = 0 [m]."""

CORNER_DISTANCE = 1.10
"""Distance from the arm's axis to the corner's apex [m]. The push of alpha = 0 runs along the bisector of the walls."""

REACH = (1.04, 1.02, 1.0, 0.98, 0.96, 0.92)
"""Candidates for the farthest fingertip distance from the arm's axis in a push [m]. The first one in reach is used."""

MIN_TOUCH_DISTANCE = 0.60
"""Least distance from the arm's axis to the touch-down [m]. Nearer, the wrist runs into its limit."""

MAX_TOUCH_DISTANCE = 0.66
"""Greatest distance from the arm's axis to the touch-down [m]. Farther, the end of the push is hardly in reach."""

PUSH_END = 0.94
"""Distance from the arm's axis to the point that the push aims at, if the touch-down distances allow it [m]."""

BASE_RADIUS = 0.2
"""Radius of the area that the arm's base takes on the table [m]; chosen."""

WALL_HALF_THICKNESS = 0.02
"""Half the thickness of a wall on the table [m]; chosen."""

WALL_HALF_HEIGHT = 0.08
"""Half the height of a wall on the table [m]; chosen. A bin's walls are as high as the crate."""

WALL_HALF_LENGTH = {"wall": 0.50, "corner": 0.30}
"""Half the length of a wall by support [m]; chosen."""

BIN_GOALS = {
    "wall": (0.0, 0.0, (-0.03, 0.12), 0.70),
    "corner_left": (0.5 * BIN_INNER[1], 30.0, (0.0, 0.0), 0.66),
    "corner_right": (-0.5 * BIN_INNER[1], -20.0, (0.09, 0.12), 0.66),
}
"""Push goals in the bin: y of the wall's middle or of the corner [m], direction [deg], lateral range [m], and least x
of the fingertips at touch-down [m].

On a push to the wall that came down at 0.69 m, the wrist hit the rim of the near wall. The thumb reaches 0.145 m to the
right of the hand, the little finger 0.05 m to the left. The push into the left corner runs 30° off the bin's length; at
45°, along the bisector, the wrist would come down on the right wall. The right corner has no room for the thumb.
Therefore the push passes beside it, turned as far as the fingers still reach it: at 30° the thumb keeps them away, at
45° the forearm comes down on the left wall."""

BIN_CENTER = np.array([WALL_DISTANCE - 0.5 * BIN_INNER[0], 0.0])
"""(2,) middle of the bin's floor [m]."""

TABLE_HALF_SIZE = (0.65, 0.70)
"""Half size of the drawn table [m]; chosen. The contact plane is unbounded."""

FRAME_GAP = 0.05
"""Least gap between the arm's base and the frame [m]. Therefore a support behind a wide frame is farther away."""

PAPER_FRAMES = {18: 0.25, 14: 0.18, 10: 0.15}
"""The paper's frame sizes by the number of objects [m]."""


@dataclass(frozen=True, slots=True)
class Layout:
    """The scene's geometry. Its origin is the intersection of the arm's axis with the level table top.

    The scene's frame belongs to the floor: z = 0 is the floor and x points to the support, even if the floor is tilted.
    A tilt turns the floor about the line at `support_distance`, which stays where it is. Seen from the floor, gravity
    and the upright arm turn the other way.

    Attributes:
        support: Support of the pile.
        frame_size: Inner side of the frame [m].
        frame_center: (2,) centre of the frame on the table [m].
        frame_yaw: Rotation of the frame about z [rad].
        walls: Walls of the support.
        support_distance: Distance from the origin to the line about which a tilt turns the floor [m].
        tilt: Slope of the floor, down toward the support [rad]; negative if the floor rises.
        goals: Push goals in a bin, the one of `support` first; empty outside a bin.
        base_position: (2,) position of the arm's base [m].
        base_yaw: Rotation of the arm's base about z [rad].
    """

    support: Support
    frame_size: float
    frame_center: Array
    frame_yaw: float
    walls: tuple[Wall, ...]
    support_distance: float
    tilt: float
    goals: tuple[PushGoal, ...] = ()
    base_position: tuple[float, float] = (0.0, 0.0)
    base_yaw: float = 0.0

    @property
    def transform_base_to_world(self) -> Pose:
        """Pose of the arm's base. The base is upright on a tilted floor, too."""
        cosine, sine = math.cos(self.tilt), math.sin(self.tilt)
        upright = np.array([[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine]])
        pivot = np.array([self.support_distance, 0.0, 0.0])
        turned, side = math.cos(self.base_yaw), math.sin(self.base_yaw)
        yaw = np.array([[turned, -side, 0.0], [side, turned, 0.0], [0.0, 0.0, 1.0]])
        return Pose(pivot + upright @ (np.array([*self.base_position, -BASE_BELOW_TABLE]) - pivot), upright @ yaw)

    @property
    def gravity(self) -> Array:
        """Acceleration of gravity (3,) in the scene [m/s²]."""
        return self.transform_base_to_world.rotation @ STANDARD_GRAVITY

    def with_rising_floor(self, angle: float) -> Layout:
        """Return the layout with a floor that rises by `angle` [rad] more toward the support; the arm stays."""
        return replace(self, tilt=self.tilt - angle)

    def transform_from(self, known: Layout) -> Pose:
        """Return the transform from the scene frame of `known` to the scene frame of this layout.

        Both frames are fixed to the arm's base. An arm that believes `known` plans in its scene frame.
        """
        if self.tilt == known.tilt:
            # The product would leave rounding errors.
            return Pose(np.zeros(3))
        return self.transform_base_to_world @ known.transform_base_to_world.inverse()

    def with_base_behind_push(self, touch: Array, point: Array, objects: Array) -> Layout:
        """Return the layout with the arm's base behind the push line.

        A fixed base cannot reach the wall at every angle of the paper. The base is therefore moved behind each push, so
        that only the angles between hand, motion and support matter.

        Args:
            touch: (2,) touch-down point of the fingertips on the table [m].
            point: (2,) point that the push aims at [m].
            objects: (n, 2) object centres [m]. The base keeps its radius off each of them.
        """
        length = math.dist(touch, point)
        direction = (point - touch) / length
        distance = min(max(PUSH_END - length, MIN_TOUCH_DISTANCE), MAX_TOUCH_DISTANCE)
        while _is_occupied(objects, touch - distance * direction):
            distance += 0.01
        x, y = touch - distance * direction
        return replace(self, base_position=(float(x), float(y)), base_yaw=math.atan2(direction[1], direction[0]))


def _is_occupied(objects: Array, base: Array) -> bool:
    return bool((np.linalg.norm(objects - base, axis=1) < BASE_RADIUS).any())


def frame_size(pile: PileConfig) -> float:
    """Return the inner side of the dropping frame [m].

    The paper states sizes for three counts. Other counts up to 30 keep the footprint per object of the 18-object pile.
    More than 30 objects fill the 0.25 m frame in layers.
    """
    if pile.frame_size is not None:
        return pile.frame_size
    if pile.count in PAPER_FRAMES:
        return PAPER_FRAMES[pile.count]
    if pile.count > 30:
        return 0.25
    return 0.25 * math.sqrt(max(pile.count, 1) / 18.0)


def make_layout(support: SupportConfig, pile: PileConfig, object_diameter: float, order_crate: bool = False) -> Layout:
    """Return the layout. The frame touches the wall, or both walls of the corner, and lies on the line alpha = 0.

    Args:
        support: Support, tilt and bin.
        pile: Number of objects and frame size.
        object_diameter: Largest diameter of an object [m].
        order_crate: Whether the crate that collects an order is beside the bin.

    Raises:
        PileError: An object does not fit into the frame, or the frame does not fit into the bin.
    """
    size, tilt = frame_size(pile), math.radians(support.tilt_deg)
    if pile.count > 0 and object_diameter > size:
        raise PileError(
            f"an object of {1000 * object_diameter:.0f} mm does not fit into the frame of {1000 * size:.0f} mm; "
            "raise pile.frame_size or lower pile.scale"
        )
    if support.bin:
        return _bin_layout(support.kind, size, tilt, order_crate)
    if support.kind == "corner":
        half_diagonal = size / math.sqrt(2.0)
        apex = max(CORNER_DISTANCE, BASE_RADIUS + FRAME_GAP + 2.0 * half_diagonal)
        walls = tuple(
            _wall(name, np.array([apex, 0.0]), yaw, along=along)
            for name, yaw, along in (
                ("wall_left", math.radians(-135.0), math.radians(135.0)),
                ("wall_right", math.radians(135.0), math.radians(-135.0)),
            )
        )
        center = np.array([apex - half_diagonal, 0.0])
        return Layout("corner", size, center, math.radians(45.0), walls, apex, tilt)
    distance = max(WALL_DISTANCE, BASE_RADIUS + FRAME_GAP + size)
    center = np.array([distance - 0.5 * size, 0.0])
    walls = (_wall("wall", np.array([distance, 0.0]), math.pi, along=None),) if support.kind == "wall" else ()
    return Layout(support.kind, size, center, 0.0, walls, distance, tilt)


def _bin_layout(support: Support, size: float, tilt: float, order_crate: bool) -> Layout:
    """Return a bin whose short, low wall is the support. The frame touches its middle, or lies in the left corner."""
    _, width, _ = BIN_INNER
    if size > width:
        raise PileError(
            f"the frame of {1000 * size:.0f} mm does not fit into the bin's width of {1000 * width:.0f} mm; "
            "lower pile.frame_size or pile.count"
        )
    goals = [
        PushGoal(name, np.array([WALL_DISTANCE, y]), math.radians(yaw), lateral_range, min_touch_x)
        for name, (y, yaw, lateral_range, min_touch_x) in BIN_GOALS.items()
    ]
    goals.sort(key=lambda goal: not goal.name.startswith(support))
    center = np.array([WALL_DISTANCE - 0.5 * size, 0.5 * (width - size) if support == "corner" else 0.0])
    walls = make_crate_walls("bin", BIN_CENTER, BIN_INNER)
    walls += make_crate_walls("order", ORDER_CENTER, ORDER_INNER) if order_crate else ()
    return Layout(support, size, center, 0.0, walls, WALL_DISTANCE, tilt, tuple(goals))


def _wall(name: str, point: Array, yaw: float, along: float | None) -> Wall:
    """Return a wall whose inner face passes through `point`; with a direction `along` [rad], the wall begins there."""
    length = WALL_HALF_LENGTH["wall" if along is None else "corner"]
    center = np.array([*point, WALL_HALF_HEIGHT])
    center[:2] -= WALL_HALF_THICKNESS * np.array([math.cos(yaw), math.sin(yaw)])
    if along is not None:
        center[:2] += length * np.array([math.cos(along), math.sin(along)])
    return Wall(name, center, np.array([WALL_HALF_THICKNESS, length, WALL_HALF_HEIGHT]), yaw)
