"""Where things stand: arm, table, walls, bin and the frame that the pile is dropped into. Pure geometry."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ..config_sections import PileConfig, SupportConfig
from ..exceptions import PileError
from ..types import STANDARD_GRAVITY, Array, Pose
from .crate import BIN_INNER, ORDER_CENTER, ORDER_INNER, crate_walls
from .push_goal import PushGoal
from .wall import Wall

SupportKind = Literal["none", "wall", "corner"]

BASE_BELOW_TABLE = 0.25
"""The table top is 0.25 m above the arm's base, where the wrist has room and the joints have margin [m]."""

WALL_DISTANCE = 1.0
"""From the arm's axis to the wall, along the push of alpha = 0 [m]."""

CORNER_DISTANCE = 1.10
"""From the arm's axis to the corner's apex; the push of alpha = 0 runs along the bisector of its walls [m]."""

REACH = (1.04, 1.02, 1.0, 0.98, 0.96, 0.92)
"""Farthest fingertip position from the arm's axis that a push asks for; the first that the arm can reach counts [m]."""

NEAREST, FARTHEST = 0.60, 0.66
"""From the arm's axis to where the fingertips touch down: nearer, the wrist runs into its limit; farther, the end of
the push comes too near to that of the arm's reach [m]."""

PUSH_END = 0.94
"""From the arm's axis to what the push aims at, where the distances above leave the choice [m]."""

ARM_FOOT = 0.2
"""Radius of the room that the arm's base takes on the table [m]."""

WALL_HALF_THICKNESS = 0.02
WALL_HALF_HEIGHT = 0.08
WALL_HALF_LENGTH = {"wall": 0.50, "corner": 0.30}
"""Half sizes of the walls [m]."""

BIN_GOALS = {
    "wall": (0.0, 0.0, (-0.03, 0.12), 0.70),
    "corner_left": (0.5 * BIN_INNER[1], 30.0, (0.0, 0.0), 0.66),
    "corner_right": (-0.5 * BIN_INNER[1], -20.0, (0.09, 0.12), 0.66),
}
"""Of a push in the bin: y of the wall's middle or of the corner [m], direction [deg], room [m], and least x of the
fingertips at touch-down [m]: on a push to the wall that came down at 0.69 m the wrist met the near wall's rim. The
thumb reaches 0.145 m to the right of the hand, the little finger 0.05 m to the left. Into the left corner the push runs
30° off the bin's length: at 45°, along the bisector, the wrist would come down on the right wall. The right corner has
no room for the thumb, so that the push passes beside it, turned as far as leaves the fingers in reach of it: at 30° the
thumb keeps them away, at 45° the forearm comes down on the left wall."""

BIN_CENTER = np.array([WALL_DISTANCE - 0.5 * BIN_INNER[0], 0.0])
"""(2,) of the bin's floor [m]."""

TABLE_HALF_SIZE = (0.65, 0.70)
"""What is drawn of the table [m]; the contact plane is unbounded."""

FRAME_GAP = 0.05
"""Between the room of the arm's base and the frame, at least [m]; a support behind a wide frame stands farther away."""

PAPER_FRAMES = {18: 0.25, 14: 0.18, 10: 0.15}


@dataclass(frozen=True, slots=True)
class Layout:
    """The scene's geometry; the world's origin is where the arm's axis meets the table top, when that is level.

    The scene's frame belongs to the floor: z = 0 is the floor and x points to the support, however it is tilted. A
    tilt turns the floor about the line through the support's foot, which stays where it is; seen from the floor,
    gravity and the upright arm turn the other way.

    Attributes:
        kind: what supports the pile.
        frame_size: inner side of the frame [m].
        frame_center: (2,) of the frame on the table [m].
        frame_yaw: the frame's rotation about z [rad].
        walls: the support's walls.
        foot: from the arm's axis to the line about which a tilt turns the floor [m].
        tilt: how far the floor slopes down toward the support [rad]; negative where it rises.
        goals: what a push may go to in a bin, the one of `kind` first; without a bin there is no choice.
        stand: (2,) where the arm stands [m].
        heading: direction in which it looks about z [rad].
    """

    kind: SupportKind
    frame_size: float
    frame_center: Array
    frame_yaw: float
    walls: tuple[Wall, ...]
    foot: float
    tilt: float
    goals: tuple[PushGoal, ...] = ()
    stand: tuple[float, float] = (0.0, 0.0)
    heading: float = 0.0

    @property
    def transform_base_to_world(self) -> Pose:
        """Where the arm's base stands: upright, wherever that is seen from the floor."""
        cosine, sine = math.cos(self.tilt), math.sin(self.tilt)
        upright = np.array([[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine]])
        foot = np.array([self.foot, 0.0, 0.0])
        turned, side = math.cos(self.heading), math.sin(self.heading)
        yaw = np.array([[turned, -side, 0.0], [side, turned, 0.0], [0.0, 0.0, 1.0]])
        return Pose(foot + upright @ (np.array([*self.stand, -BASE_BELOW_TABLE]) - foot), upright @ yaw)

    @property
    def gravity(self) -> Array:
        """Acceleration of gravity (3,) in the scene [m/s²]."""
        return self.transform_base_to_world.rotation @ STANDARD_GRAVITY

    def rising(self, angle: float) -> Layout:
        """Return the layout with a floor that rises toward the support by `angle` [rad] more, before the same arm."""
        return replace(self, tilt=self.tilt - angle)

    def transform_from(self, known: Layout) -> Pose:
        """Return where the scene's frame of `known` lies in that of this layout.

        An arm that takes the floor to be as in `known` counts from there; both frames are fixed to its base.
        """
        if self.tilt == known.tilt:
            # Exactly, where the product would leave rounding.
            return Pose(np.zeros(3))
        return self.transform_base_to_world @ known.transform_base_to_world.inverse()

    def behind(self, touch: Array, point: Array, objects: Array) -> Layout:
        """Return the layout with the arm behind the line of the push, so that the whole push is within its reach.

        What happens in the pile then does not depend on how far the arm would have to stretch to one side: the paper's
        angles are between hand, motion and support.

        Args:
            touch: (2,) where the fingertips touch the table [m].
            point: (2,) what the push aims at [m].
            objects: (n, 2) of the objects' centres, on none of which the arm may stand [m].
        """
        length = math.dist(touch, point)
        direction = (point - touch) / length
        distance = min(max(PUSH_END - length, NEAREST), FARTHEST)
        while _occupied(objects, touch - distance * direction):
            distance += 0.01
        x, y = touch - distance * direction
        return replace(self, stand=(float(x), float(y)), heading=math.atan2(direction[1], direction[0]))


def _occupied(objects: Array, stand: Array) -> bool:
    return bool((np.linalg.norm(objects - stand, axis=1) < ARM_FOOT).any())


def frame_size(pile: PileConfig) -> float:
    """Return the inner side of the dropping frame [m].

    The paper's sizes for its three counts; other counts keep the footprint per object of the 18-object pile up to 30
    objects; above that the 0.25 m frame is filled in layers.
    """
    if pile.frame_size is not None:
        return pile.frame_size
    if pile.count in PAPER_FRAMES:
        return PAPER_FRAMES[pile.count]
    if pile.count > 30:
        return 0.25
    return 0.25 * math.sqrt(max(pile.count, 1) / 18.0)


def make_layout(support: SupportConfig, pile: PileConfig, object_diameter: float, order: bool = False) -> Layout:
    """Return the layout; the frame touches the wall, or both walls of the corner, and lies on the line alpha = 0.

    With `order`, the crate that an order is collected in stands beside the bin.

    Raises:
        PileError: where an object does not fit into the frame, or the frame into the bin.
    """
    size, tilt = frame_size(pile), math.radians(support.tilt_deg)
    if pile.count > 0 and object_diameter > size:
        raise PileError(
            f"an object of {1000 * object_diameter:.0f} mm does not fit into the frame of {1000 * size:.0f} mm; "
            "raise pile.frame_size or lower pile.scale"
        )
    if support.bin:
        return _bin_layout(support.kind, size, tilt, order)
    if support.kind == "corner":
        half_diagonal = size / math.sqrt(2.0)
        apex = max(CORNER_DISTANCE, ARM_FOOT + FRAME_GAP + 2.0 * half_diagonal)
        walls = tuple(
            _wall(name, np.array([apex, 0.0]), yaw, along=along)
            for name, yaw, along in (
                ("wall_left", math.radians(-135.0), math.radians(135.0)),
                ("wall_right", math.radians(135.0), math.radians(-135.0)),
            )
        )
        center = np.array([apex - half_diagonal, 0.0])
        return Layout("corner", size, center, math.radians(45.0), walls, apex, tilt)
    foot = max(WALL_DISTANCE, ARM_FOOT + FRAME_GAP + size)
    center = np.array([foot - 0.5 * size, 0.0])
    walls = (_wall("wall", np.array([foot, 0.0]), math.pi, along=None),) if support.kind == "wall" else ()
    return Layout(support.kind, size, center, 0.0, walls, foot, tilt)


def _bin_layout(kind: SupportKind, size: float, tilt: float, order: bool) -> Layout:
    """Return a bin whose short, low wall is the support; the frame touches it in the middle or in the left corner."""
    _, width, _ = BIN_INNER
    if size > width:
        raise PileError(
            f"the frame of {1000 * size:.0f} mm does not fit into the bin's width of {1000 * width:.0f} mm; "
            "lower pile.frame_size or pile.count"
        )
    goals = [
        PushGoal(name, np.array([WALL_DISTANCE, y]), math.radians(yaw), room, nearest)
        for name, (y, yaw, room, nearest) in BIN_GOALS.items()
    ]
    goals.sort(key=lambda goal: not goal.name.startswith(kind))
    center = np.array([WALL_DISTANCE - 0.5 * size, 0.5 * (width - size) if kind == "corner" else 0.0])
    walls = crate_walls("bin", BIN_CENTER, BIN_INNER)
    walls += crate_walls("order", ORDER_CENTER, ORDER_INNER) if order else ()
    return Layout(kind, size, center, 0.0, walls, WALL_DISTANCE, tilt, tuple(goals))


def _wall(name: str, foot: Array, yaw: float, along: float | None) -> Wall:
    """Place a wall whose inner face passes through `foot`; it starts there where `along` gives its direction."""
    length = WALL_HALF_LENGTH["wall" if along is None else "corner"]
    center = np.array([*foot, WALL_HALF_HEIGHT])
    center[:2] -= WALL_HALF_THICKNESS * np.array([math.cos(yaw), math.sin(yaw)])
    if along is not None:
        center[:2] += length * np.array([math.cos(along), math.sin(along)])
    return Wall(name, center, np.array([WALL_HALF_THICKNESS, length, WALL_HALF_HEIGHT]), yaw)
