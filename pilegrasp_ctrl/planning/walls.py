"""Walls of the scene, and the four walls of a crate. Pure geometry."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..types import Array

BIN_INNER = (0.56, 0.38, 0.16)
"""Inner length, width and height of the IFCO crate in the authors' laboratory (their vision's `ifco.yaml`) [m]."""

BIN_THICKNESS = (0.0175, 0.0075)
"""Thickness of the short and of the long walls [m]; the laboratory's model measures 0.595 x 0.395 m outside."""

ORDER_INNER = (0.38, 0.28, 0.16)
"""Inner length, width and height of the crate that collects an order [m]; chosen, half as large as the bin."""

ORDER_CENTER = np.array([0.60, 0.385])
"""(2,) middle of the order crate's floor [m]; chosen on the left of the bin and within easy reach."""


@dataclass(frozen=True, slots=True)
class Wall:
    """A box on the floor.

    Attributes:
        name: Name of the geom.
        center: (3,) centre of the box [m].
        half_size: (3,) half size of the box [m], the first entry along the inward normal.
        yaw: Direction of the inward normal about z [rad].
        crate: Name of the crate that the wall belongs to; None for a wall that stands alone. Only a crate has rims that
            are monitored.
    """

    name: str
    center: Array
    half_size: Array
    yaw: float
    crate: str | None = None


def are_inside(points: Array, center: Array, inner: tuple[float, float, float]) -> NDArray[np.bool_]:
    """Return which points (n, 3) [m] lie in a crate and below its rim.

    Args:
        points: (n, 3) points [m].
        center: (2,) middle of the crate's floor [m].
        inner: Inner length along x, width along y and height [m].
    """
    length, width, height = inner
    off = np.abs(points[:, :2] - center)
    return (off[:, 0] < 0.5 * length) & (off[:, 1] < 0.5 * width) & (points[:, 2] < height)


def make_crate_walls(name: str, center: Array, inner: tuple[float, float, float]) -> tuple[Wall, ...]:
    """Return the four walls of a crate whose sides are parallel to x and y.

    Args:
        name: Name of the crate. Seen from the arm, its walls are `{name}_far`, `_near`, `_left` and `_right`.
        center: (2,) middle of the floor [m].
        inner: Inner length along x, width along y and height [m].
    """
    length, width, height = inner
    short, long = BIN_THICKNESS
    sides = {
        "far": (0.5 * (length + short), 0.0, math.pi, short, width + 2.0 * long),
        "near": (-0.5 * (length + short), 0.0, 0.0, short, width + 2.0 * long),
        "left": (0.0, 0.5 * (width + long), -0.5 * math.pi, long, length),
        "right": (0.0, -0.5 * (width + long), 0.5 * math.pi, long, length),
    }
    return tuple(
        Wall(
            name=f"{name}_{side}",
            center=np.array([center[0] + x, center[1] + y, 0.5 * height]),
            half_size=0.5 * np.array([thickness, along, height]),
            yaw=yaw,
            crate=name,
        )
        for side, (x, y, yaw, thickness, along) in sides.items()
    )
