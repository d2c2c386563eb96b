"""A wall of the scene."""

from __future__ import annotations

from dataclasses import dataclass

from ..types import Array


@dataclass(frozen=True, slots=True)
class Wall:
    """A box that stands on the floor.

    Attributes:
        name: of its geom.
        center: (3,) [m].
        half_size: (3,) [m], the first along the inward normal.
        yaw: angle of its inward normal about z [rad].
        crate: what it is a side of, or "" where it stands alone and has no rim to be wary of.
    """

    name: str
    center: Array
    half_size: Array
    yaw: float
    crate: str = ""
