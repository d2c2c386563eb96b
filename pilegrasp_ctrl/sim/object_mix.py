"""Several kinds of object in one pile."""

from __future__ import annotations

from dataclasses import dataclass

from .object_model import ObjectModel


@dataclass(frozen=True, slots=True)
class ObjectMix:
    """Kinds that take turns: object i is of kind i modulo their number. None of them is tied by a net.

    Attributes:
        kinds: two or more; one that is named twice is twice as frequent.
    """

    kinds: tuple[ObjectModel, ...]

    @property
    def net(self) -> None:
        """None of them has one."""
        return None

    @property
    def shape(self) -> str:
        """No single one."""
        return "mix"

    @property
    def bounding_radius(self) -> float:
        """Radius of the sphere about the centre of mass that encloses the largest [m]."""
        return max(kind.bounding_radius for kind in self.kinds)

    @property
    def diameter(self) -> float:
        """Smallest width of the widest [m]."""
        return max(kind.diameter for kind in self.kinds)

    @property
    def flank_radius(self) -> float:
        """Radius of the upright cylinder that encloses each of them [m]."""
        return max(kind.flank_radius for kind in self.kinds)

    def share_out(self, count: int) -> list[ObjectModel]:
        """Return the kind of each of `count` objects."""
        return [self.kinds[index % len(self.kinds)] for index in range(count)]


Objects = ObjectModel | ObjectMix
"""What a pile is made of."""
