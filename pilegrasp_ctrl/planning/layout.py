"""Layout of the scene: arm base, table, walls, bin and the frame that the pile is dropped into. Pure geometry."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from ..exceptions import PileError
from ..sections import KnownConfig, OrderConfig, PileConfig, SupportConfig
from ..types import STANDARD_GRAVITY, Array, Pose
from ..vectors import product, rotated
from .arm_room import ArmRoom, default_room
from .bin_layout import frame_in_bin, place_bin, place_frame, place_order_crate
from .crate import Crate
from .push_goal import PushGoal
from .walls import Wall

Support = Literal["none", "wall", "corner"]

WALL_HALF_THICKNESS = 0.02
"""Half the thickness of a wall on the table [m]; chosen."""

WALL_HALF_HEIGHT = 0.08
"""Half the height of a wall on the table [m]; chosen. A bin's walls are as high as the crate."""

WALL_HALF_LENGTH = {"wall": 0.50, "corner": 0.30}
"""Half the length of a wall by support [m]; chosen."""

TABLE_HALF_SIZE = (0.65, 0.70)
"""Half size of the drawn table [m]; chosen. The contact plane is unbounded."""

START_HEIGHT = 0.22
"""Height of the fingertips over the surface at the start of an attempt, and between bin and crate [m]; chosen.

It is higher over higher walls, see `OVER_RIM`."""

OVER_RIM = 0.06
"""Least height of the fingertips over the rims of crates at the start of an attempt [m]; chosen."""

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
        bin: Bin; None without one. Its length runs along x, also if the bin is turned: then the arm's base is turned.
        order_crate: Crate that collects an order; None without one.
        goals: Push goals in a bin, the one of `support` first; empty outside a bin, and until they are found.
        base_position: (2,) position of the arm's base [m].
        base_yaw: Rotation of the arm's base about z [rad].
        base_rise: Height of the arm's base over its usual one above the floor [m].
        support_error: Displacement along x and y [m] and turn [rad] of the support from where it is, in a layout as the
            arm believes it.
        room: Room of the arm.
    """

    support: Support
    frame_size: float
    frame_center: Array
    frame_yaw: float
    walls: tuple[Wall, ...]
    support_distance: float
    tilt: float
    bin: Crate | None = None
    order_crate: Crate | None = None
    goals: tuple[PushGoal, ...] = field(default=(), repr=False)
    base_position: tuple[float, float] = (0.0, 0.0)
    base_yaw: float = 0.0
    base_rise: float = 0.0
    support_error: tuple[float, float, float] = (0.0, 0.0, 0.0)
    room: ArmRoom = field(default_factory=default_room)

    @property
    def transform_base_to_world(self) -> Pose:
        """Pose of the arm's base. The base is upright on a tilted floor, too."""
        cosine, sine = math.cos(self.tilt), math.sin(self.tilt)
        upright = np.array([[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine]])
        pivot = np.array([self.support_distance, 0.0, 0.0])
        turned, side = math.cos(self.base_yaw), math.sin(self.base_yaw)
        yaw = np.array([[turned, -side, 0.0], [side, turned, 0.0], [0.0, 0.0, 1.0]])
        base = np.array([*self.base_position, self.base_rise - self.room.base_below_table])
        return Pose(pivot + rotated(upright, base - pivot), product(upright, yaw))

    @property
    def start_height(self) -> float:
        """Height of the fingertips over the floor at the start of an attempt, and between two crates [m]."""
        crates = [crate.top for crate in (self.bin, self.order_crate) if crate]
        return max([START_HEIGHT, *(top + OVER_RIM for top in crates)])

    @property
    def gravity(self) -> Array:
        """Acceleration of gravity (3,) in the scene [m/s²]."""
        return rotated(self.transform_base_to_world.rotation, STANDARD_GRAVITY)

    def with_rising_floor(self, angle: float) -> Layout:
        """Return the layout with a floor that rises by `angle` [rad] more toward the support; the arm stays."""
        return replace(self, tilt=self.tilt - angle)

    def with_goals(self, goals: Sequence[PushGoal]) -> Layout:
        """Return the layout with push goals, those of its support first."""
        return replace(self, goals=tuple(sorted(goals, key=lambda goal: not goal.name.startswith(self.support))))

    def transform_from(self, known: Layout) -> Pose:
        """Return the transform from the scene frame of `known` to the scene frame of this layout.

        Both frames are fixed to the arm's base. An arm that believes `known` plans in its scene frame.
        """
        if self.tilt == known.tilt and self.base_rise == known.base_rise:
            # The product would leave rounding errors.
            return Pose(np.zeros(3))
        return self.transform_base_to_world @ known.transform_base_to_world.inverse()

    def as_believed(self, known: KnownConfig) -> Layout:
        """Return the layout with the support where the arm believes it; the line about which a tilt turns stays."""
        x, y, turn = known.support_x, known.support_y, math.radians(known.support_yaw_deg)
        if (x, y, turn) == (0.0, 0.0, 0.0):
            return self
        cosine, sine = math.cos(turn), math.sin(turn)
        pivot = np.array([self.support_distance, 0.0])

        def moved(point: Array) -> Array:
            return pivot + np.array([x, y]) + rotated([[cosine, -sine], [sine, cosine]], point - pivot)

        walls = tuple(
            replace(wall, center=np.array([*moved(wall.center[:2]), wall.center[2]]), yaw=wall.yaw + turn)
            for wall in self.walls
        )
        goals = tuple(replace(goal, anchor=moved(goal.anchor), yaw=goal.yaw + turn) for goal in self.goals)
        return replace(self, walls=walls, goals=goals, support_error=(x, y, turn))

    def with_base_of(self, other: Layout) -> Layout:
        """Return the layout with the arm's base where it stands in `other`."""
        return replace(self, base_position=other.base_position, base_yaw=other.base_yaw)

    def with_lower_floor(self, depth: float) -> Layout:
        """Return the layout with a floor that is `depth` [m] lower; the arm stays."""
        return replace(self, base_rise=self.base_rise + depth)

    def with_base_behind_push(self, touch: Array, point: Array, objects: Array) -> Layout:
        """Return the layout with the arm's base behind the push line.

        A fixed base cannot reach the wall at every angle of the paper. The base is therefore moved behind each push, so
        that only the angles between hand, motion and support matter.

        Args:
            touch: (2,) touch-down point of the fingertips on the table [m].
            point: (2,) point that the push aims at [m].
            objects: (n, 2) object centres [m]. The base keeps its radius off each of them.
        """
        length, room = math.dist(touch, point), self.room
        direction = (point - touch) / length
        distance = min(max(room.push_end - length, room.min_touch_distance), room.max_touch_distance)
        while _is_occupied(objects, touch - distance * direction, room.base_radius):
            distance += 0.01
        x, y = touch - distance * direction
        return replace(self, base_position=(float(x), float(y)), base_yaw=math.atan2(direction[1], direction[0]))


def _is_occupied(objects: Array, base: Array, radius: float) -> bool:
    return bool((np.linalg.norm(objects - base, axis=1) < radius).any())


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


def make_layout(
    support: SupportConfig,
    pile: PileConfig,
    object_diameter: float,
    order: OrderConfig | None = None,
    room: ArmRoom | None = None,
    frame: float | None = None,
) -> Layout:
    """Return the layout. The frame touches the wall, or both walls of the corner, and lies on the line alpha = 0.

    Args:
        support: Support, tilt and bin.
        pile: Number of objects and frame size.
        object_diameter: Largest diameter of an object [m].
        order: Order, whose crate is beside the bin; None without a crate.
        room: Room of the arm; that of the WAM if absent.
        frame: Side of the frame of a user's objects [m]; that of the paper's objects if absent.

    Raises:
        PileError: An object does not fit into the frame, or the frame does not fit into the bin.
        ConfigurationError: The bin or the crate cannot stand there.
    """
    size, tilt = frame_size(pile) if frame is None else frame, math.radians(support.tilt_deg)
    room = default_room() if room is None else room
    if support.bin:
        size = frame_in_bin(size, pile, support.bin_size)
    if pile.count > 0 and object_diameter > size:
        raise PileError(
            f"an object of {1000 * object_diameter:.0f} mm does not fit into the frame of {1000 * size:.0f} mm; "
            "raise pile.frame_size or lower pile.scale"
        )
    if support.bin:
        return _bin_layout(support, pile, size, tilt, order, room)
    if support.kind == "corner":
        half_diagonal = size / math.sqrt(2.0)
        apex = max(room.corner_distance, room.base_radius + FRAME_GAP + 2.0 * half_diagonal)
        walls = tuple(
            _wall(name, np.array([apex, 0.0]), yaw, along=along)
            for name, yaw, along in (
                ("wall_left", math.radians(-135.0), math.radians(135.0)),
                ("wall_right", math.radians(135.0), math.radians(-135.0)),
            )
        )
        center = np.array([apex - half_diagonal, 0.0])
        return Layout("corner", size, center, math.radians(45.0), walls, apex, tilt, room=room)
    distance = max(room.wall_distance, room.base_radius + FRAME_GAP + size)
    center = np.array([distance - 0.5 * size, 0.0])
    walls = (_wall("wall", np.array([distance, 0.0]), math.pi, along=None),) if support.kind == "wall" else ()
    return Layout(support.kind, size, center, 0.0, walls, distance, tilt, room=room)


def _bin_layout(
    support: SupportConfig, pile: PileConfig, size: float, tilt: float, order: OrderConfig | None, room: ArmRoom
) -> Layout:
    """Return a bin whose far, low wall is the support. The frame touches its middle, or lies in the left corner."""
    crate, base_yaw = place_bin(support, room.wall_distance, room.base_radius)
    order_crate = place_order_crate(order, crate) if order else None
    center = place_frame(pile, size, crate, support.kind == "corner")
    walls = crate.walls() + (order_crate.walls() if order_crate else ())
    return Layout(
        support.kind,
        size,
        center,
        0.0,
        walls,
        crate.far,
        tilt,
        bin=crate,
        order_crate=order_crate,
        base_yaw=base_yaw,
        room=room,
    )


def _wall(name: str, point: Array, yaw: float, along: float | None) -> Wall:
    """Return a wall whose inner face passes through `point`; with a direction `along` [rad], the wall begins there."""
    length = WALL_HALF_LENGTH["wall" if along is None else "corner"]
    center = np.array([*point, WALL_HALF_HEIGHT])
    center[:2] -= WALL_HALF_THICKNESS * np.array([math.cos(yaw), math.sin(yaw)])
    if along is not None:
        center[:2] += length * np.array([math.cos(along), math.sin(along)])
    return Wall(name, center, np.array([WALL_HALF_THICKNESS, length, WALL_HALF_HEIGHT]), yaw)
