"""A crate: the bin, or the crate that collects an order. Pure geometry."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..types import Array
from .walls import Wall


@dataclass(frozen=True, slots=True)
class Crate:
    """A crate whose sides are parallel to x and y.

    Attributes:
        name: Name of the crate. Seen from the arm, its walls are `{name}_far`, `_near`, `_left` and `_right`.
        center: (2,) middle of the floor [m].
        inner: Inner length along x, width along y and height [m].
        thickness: Thickness of the far and near, and of the left and right walls [m].
        heights: Heights of the far, near, left and right wall [m].
    """

    name: str
    center: tuple[float, float]
    inner: tuple[float, float, float]
    thickness: tuple[float, float]
    heights: tuple[float, float, float, float]

    @property
    def far(self) -> float:
        """X of the far wall's inner face [m]."""
        return self.center[0] + 0.5 * self.inner[0]

    @property
    def top(self) -> float:
        """Height of the highest wall [m]."""
        return max(self.heights)

    def walls(self) -> tuple[Wall, ...]:
        """Return the far, near, left and right wall."""
        (length, width, _), (short, long) = self.inner, self.thickness
        sides = {
            "far": (0.5 * (length + short), 0.0, math.pi, short, width + 2.0 * long),
            "near": (-0.5 * (length + short), 0.0, 0.0, short, width + 2.0 * long),
            "left": (0.0, 0.5 * (width + long), -0.5 * math.pi, long, length),
            "right": (0.0, -0.5 * (width + long), 0.5 * math.pi, long, length),
        }
        return tuple(
            Wall(
                name=f"{self.name}_{side}",
                center=np.array([self.center[0] + x, self.center[1] + y, 0.5 * height]),
                half_size=0.5 * np.array([thickness, along, height]),
                yaw=yaw,
                crate=self.name,
            )
            for (side, (x, y, yaw, thickness, along)), height in zip(sides.items(), self.heights, strict=True)
        )

    def are_inside(self, points: Array) -> NDArray[np.bool_]:
        """Return which points (n, 3) [m] lie between the walls and below the crate's height."""
        length, width, height = self.inner
        off = np.abs(points[:, :2] - np.array(self.center))
        return (off[:, 0] < 0.5 * length) & (off[:, 1] < 0.5 * width) & (points[:, 2] < height)

    def distance_to(self, point: tuple[float, float]) -> float:
        """Return the distance from a point on the floor to the crate's outer faces [m]; 0 inside."""
        gaps = (
            max(0.0, abs(at - middle) - 0.5 * inner - wall)
            for at, middle, inner, wall in zip(point, self.center, self.inner[:2], self.thickness, strict=True)
        )
        return math.hypot(*gaps)
