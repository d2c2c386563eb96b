"""A capsule: the shape by which a link is kept off obstacles."""

from __future__ import annotations

from dataclasses import dataclass

from ..exceptions import ArgumentError
from ..types import Array, frozen_array


@dataclass(frozen=True, slots=True, eq=False)
class Capsule:
    """All points within `radius` of a segment that is fixed to a frame; a segment of no length makes it a ball.

    Attributes:
        frame: Name of the frame, usually a link.
        start: (3,) One end of the segment, in the frame [m].
        end: (3,) The other end [m].
        radius: Radius [m].

    Raises:
        ArgumentError: The frame is no name, an end is not three finite numbers, or the radius is not positive.
    """

    frame: str
    start: Array
    end: Array
    radius: float

    def __post_init__(self) -> None:
        if not isinstance(self.frame, str) or not self.frame:
            raise ArgumentError(f"a capsule has the frame {self.frame!r}; give the name of a link or frame of the arm")
        for name in ("start", "end"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), (3,), f"{name} of {self.frame}'s capsule"))
        radius = frozen_array(self.radius, (), f"radius of {self.frame}'s capsule").item()
        if not radius > 0.0:
            raise ArgumentError(f"radius = {radius:g} m of {self.frame}'s capsule must be positive")
        object.__setattr__(self, "radius", radius)
