"""The rigid shovel: a floor with a thin leading edge, two side walls and a back wall."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np

from ..vectors import in_order
from .hand_parts import DARK, finger_directions, frame_quaternion

PLASTIC = (0.20, 0.42, 0.62, 1.0)
"""Colour of the shovel (rgba)."""

BRACKET_RADIUS = 0.012
"""Radius of the strut that carries the shovel [m], chosen; the strut is only drawn."""


def add_shovel(spec: mujoco.MjSpec, root: Any, parameters: dict[str, Any]) -> None:
    """Add the shovel to the sensor's body `root` in the flange's frame, with the numbers of `robot.toml`."""
    scoop, hand = parameters["scoop"], parameters["hand"]
    along, normal = finger_directions(hand["finger_angle_deg"])
    body = root.add_body(name="scoop", pos=hand["tool_origin"], quat=frame_quaternion(along, normal))
    length, width, half = scoop["length"], scoop["width"], scoop["thickness"] / 2.0
    wall, back = scoop["wall_height"] / 2.0, scoop["back_height"] / 2.0
    side = scoop["wall_length"] / 2.0
    # In the tool frame the leading edge is the y axis. The floor is behind it, with its underside at z = 0.
    boxes = {
        "floor": ([-length / 2.0, 0.0, half], [length / 2.0, width / 2.0, half]),
        "left": ([side - length, width / 2.0 - half, wall], [side, half, wall]),
        "right": ([side - length, -width / 2.0 + half, wall], [side, half, wall]),
        "back": ([-length + half, 0.0, back], [half, width / 2.0, back]),
    }
    area = {part: math.prod(sorted(size)[1:]) for part, (_, size) in boxes.items()}
    for part, (center, size) in boxes.items():
        body.add_geom(
            name=f"scoop_{part}",
            type=mujoco.mjtGeom.mjGEOM_BOX,
            pos=center,
            size=size,
            mass=scoop["mass"] * area[part] / in_order(area.values()),
            rgba=PLASTIC,
            contype=0,
            conaffinity=0,
        )
    _add_bracket(root, parameters, hand["tool_origin"] - length * along + back * normal)


def _add_bracket(root: Any, parameters: dict[str, Any], back_center: np.ndarray) -> None:
    """Add the strut from the sensor to the back wall. It is only drawn, because no object can reach it."""
    root.add_geom(
        name="bracket",
        type=mujoco.mjtGeom.mjGEOM_CAPSULE,
        fromto=[0.0, 0.0, parameters["sensor"]["top"], *back_center],
        size=[BRACKET_RADIUS, 0.0, 0.0],
        mass=0.0,
        rgba=DARK,
        contype=0,
        conaffinity=0,
    )
