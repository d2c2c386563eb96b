"""Where things stand: arm, table, walls and the frame that the pile is dropped into. Pure geometry."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..config_sections import PileConfig, SupportConfig
from ..exceptions import PileError
from ..types import Array, Pose

SupportKind = Literal["none", "wall", "corner"]

BASE_BELOW_TABLE = 0.25
"""The table top is 0.25 m above the arm's base, where the wrist has room and the joints have margin [m]."""

WALL_DISTANCE = 1.0
"""From the arm's axis to the wall, along the push of alpha = 0 [m]."""

CORNER_DISTANCE = 1.10
"""From the arm's axis to the corner's apex; the push of alpha = 0 runs along the bisector of its walls [m]."""

REACH = (1.04, 1.0, 0.96, 0.92)
"""Farthest fingertip position from the arm's axis that a push asks for; the first that the arm can reach counts [m]."""

WALL_HALF_THICKNESS = 0.02
WALL_HALF_HEIGHT = 0.08
WALL_HALF_LENGTH = {"wall": 0.50, "corner": 0.30}
"""Half sizes of the walls [m]."""

TABLE_HALF_SIZE = (0.65, 0.70)
"""What is drawn of the table [m]; the contact plane is unbounded."""

PAPER_FRAMES = {18: 0.25, 14: 0.18, 10: 0.15}


@dataclass(frozen=True, slots=True)
class Wall:
    """A vertical wall: centre (3,) and half sizes (3,) [m] of its box, angle of its inward normal about z [rad]."""

    name: str
    center: Array
    half_size: Array
    yaw: float


@dataclass(frozen=True, slots=True)
class Layout:
    """The scene's geometry; the world's origin is where the arm's axis meets the table top.

    Attributes:
        kind: what supports the pile.
        frame_size: inner side of the frame [m].
        frame_center: (2,) of the frame on the table [m].
        frame_yaw: the frame's rotation about z [rad].
        walls: the support's walls.
    """

    kind: SupportKind
    frame_size: float
    frame_center: Array
    frame_yaw: float
    walls: tuple[Wall, ...]

    @property
    def transform_base_to_world(self) -> Pose:
        """Where the arm's base stands."""
        return Pose(np.array([0.0, 0.0, -BASE_BELOW_TABLE]))


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


def make_layout(support: SupportConfig, pile: PileConfig, object_diameter: float) -> Layout:
    """Return the layout; the frame touches the wall, or both walls of the corner, and lies on the line alpha = 0.

    Raises:
        PileError: where an object does not fit into the frame.
    """
    size = frame_size(pile)
    if pile.count > 0 and object_diameter > size:
        raise PileError(
            f"an object of {1000 * object_diameter:.0f} mm does not fit into the frame of {1000 * size:.0f} mm; "
            "raise pile.frame_size or lower pile.scale"
        )
    if support.kind == "corner":
        half_diagonal = size / math.sqrt(2.0)
        walls = tuple(
            _wall(name, np.array([CORNER_DISTANCE, 0.0]), yaw, along=along)
            for name, yaw, along in (
                ("wall_left", math.radians(-135.0), math.radians(135.0)),
                ("wall_right", math.radians(135.0), math.radians(-135.0)),
            )
        )
        center = np.array([CORNER_DISTANCE - half_diagonal, 0.0])
        return Layout("corner", size, center, math.radians(45.0), walls)
    center = np.array([WALL_DISTANCE - 0.5 * size, 0.0])
    walls = (_wall("wall", np.array([WALL_DISTANCE, 0.0]), math.pi, along=None),) if support.kind == "wall" else ()
    return Layout(support.kind, size, center, 0.0, walls)


def _wall(name: str, foot: Array, yaw: float, along: float | None) -> Wall:
    """Place a wall whose inner face passes through `foot`; it starts there where `along` gives its direction."""
    length = WALL_HALF_LENGTH["wall" if along is None else "corner"]
    center = np.array([*foot, WALL_HALF_HEIGHT])
    center[:2] -= WALL_HALF_THICKNESS * np.array([math.cos(yaw), math.sin(yaw)])
    if along is not None:
        center[:2] += length * np.array([math.cos(along), math.sin(along)])
    return Wall(name, center, np.array([WALL_HALF_THICKNESS, length, WALL_HALF_HEIGHT]), yaw)
