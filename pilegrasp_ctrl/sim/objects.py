"""The objects of a pile, by the keys of `pile`: shipped ones, a user's own, and mixes of them."""

from __future__ import annotations

from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

from ..exceptions import ConfigurationError
from ..scenarios import is_file, object_files, object_parts
from ..sections import PileConfig
from .object_file import read_object
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


OBJECT_MODELS = {name: read_object(file) for name, file in object_files().items()}
"""The kinds that ship, in the variant "real"."""


def object_model(name: str, mass: float | None = None, scale: float = 1.0, variant: str = "real") -> ObjectModel:
    """Return a kind by name or file, with another mass [kg] (and the restitution that goes with it) or size if given.

    Raises:
        ConfigurationError: for an unknown name, with the known ones or the nearest; for a file or a variant that cannot
            be used.
    """
    if is_file(name):
        kind = read_object(Path(name), variant)
    elif name in OBJECT_MODELS:
        kind = read_object(object_files()[name], variant) if variant != "real" else OBJECT_MODELS[name]
    else:
        close = get_close_matches(name, OBJECT_MODELS, n=1)
        remedy = f"did you mean {close[0]!r}?" if close else f"choose from {', '.join(OBJECT_MODELS)}"
        raise ConfigurationError(f"pile.object = {name!r} is not known; {remedy}")
    return (kind if mass is None else kind.with_mass(mass)).scaled(scale)


def objects_of(pile: PileConfig) -> Objects:
    """Return the kind that a scenario asks for, or the mix of those that it joins by `+`.

    Raises:
        ConfigurationError: as `object_model`; where nets do not share out `pile.count`, or are to be mixed.
    """
    kinds = tuple(
        object_model(name, pile.mass, pile.scale, pile.variant).with_friction(pile.friction)
        for name in object_parts(pile.object)
    )
    kind = kinds[0]
    if len(kinds) > 1:
        if tied := [each.name for each in kinds if each.net is not None]:
            raise ConfigurationError(f"pile.object: {tied[0]!r} is tied by nets, which cannot be mixed; leave it out")
        return ObjectMix(kinds)
    if kind.net is not None and (left := pile.count % kind.net.members):
        fewer, members = pile.count - left, kind.net.members
        choice = f"{fewer} or {fewer + members}" if fewer else str(members)
        raise ConfigurationError(
            f"pile.count = {pile.count} counts single objects, and a net of {kind.name!r} holds {members}; "
            f"make it {choice}"
        )
    return kind
