"""Obstacles that do not move: planes and boxes."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

from ..exceptions import ArgumentError
from ..types import Array, Pose, frozen_array


@dataclass(frozen=True, slots=True, eq=False)
class Plane:
    """A half-space such as the floor: all points x of the world with `normal · x <= offset`.

    Attributes:
        normal: (3,) Normal into the free space, in world axes; of any length, kept as a unit vector.
        offset: Distance of the surface from the world's origin, along the normal [m].
        name: Name in `active_limits`.

    Raises:
        ArgumentError: The normal is zero, or a value is not a finite number.
    """

    normal: Array = (0.0, 0.0, 1.0)  # type: ignore[assignment]
    offset: float = 0.0
    name: str = "plane"

    def __post_init__(self) -> None:
        _check_name(self.name, "Plane")
        x, y, z = frozen_array(self.normal, (3,), f"normal of {self.name}").tolist()
        length = sqrt(x * x + y * y + z * z)
        if length == 0.0:
            raise ArgumentError(f"normal of {self.name} is zero; give a direction, such as (0, 0, 1) for a floor")
        unit = frozen_array([x / length, y / length, z / length], (3,), "normal")
        object.__setattr__(self, "normal", unit)
        object.__setattr__(self, "offset", frozen_array(self.offset, (), f"offset of {self.name}").item())


@dataclass(frozen=True, slots=True, eq=False)
class Box:
    """A box.

    Attributes:
        size: (3,) Lengths of its edges [m].
        pose: `transform_box_to_world`, of the middle of the box.
        name: Name in `active_limits`.

    Raises:
        ArgumentError: A length is not positive and finite, or the pose is not a `Pose`.
    """

    size: Array
    pose: Pose
    name: str = "box"

    def __post_init__(self) -> None:
        _check_name(self.name, "Box")
        size = frozen_array(self.size, (3,), f"size of {self.name}")
        if not (size > 0.0).all():
            raise ArgumentError(f"size = {size.tolist()} m of {self.name} must be positive along each edge")
        if not isinstance(self.pose, Pose):
            raise ArgumentError(f"pose of {self.name} must be a Pose of its middle, not {type(self.pose).__name__}")
        object.__setattr__(self, "size", size)


Obstacle = Plane | Box
"""Type of an obstacle."""


def _check_name(name: str, kind: str) -> None:
    if not isinstance(name, str) or not name:
        raise ArgumentError(f"a {kind} has the name {name!r}; give a text, which active_limits will show")
