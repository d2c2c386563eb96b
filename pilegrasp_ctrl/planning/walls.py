"""Walls of the scene. Pure geometry."""

from __future__ import annotations

from dataclasses import dataclass

from ..types import Array

RIM_HEIGHT = 0.02
"""Height of a crate's rim, the uppermost part of its walls, which no hand may touch [m]; chosen."""


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
