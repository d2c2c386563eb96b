"""The objects of a pile: shipped models, models of a user, and mixes of several models."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ..exceptions import ConfigurationError, remedy_for
from ..scenarios import is_file, object_files, object_parts
from ..sections import PileConfig
from .object_file import read_object
from .object_model import ObjectModel

OBJECT_MODELS = {name: read_object(file) for name, file in object_files().items()}
"""Shipped models by name, in the variant "real"."""


@dataclass(frozen=True, slots=True)
class ObjectMix:
    """Several models in turn: object i has model i modulo their number. No model has a net.

    Attributes:
        object_models: Two or more models; a model that is named twice is twice as frequent.
    """

    object_models: tuple[ObjectModel, ...]

    @property
    def net(self) -> None:
        """Net of the objects: None for a mix."""
        return None

    @property
    def shape(self) -> str:
        """Shape of the objects: "mix", which has no single shape."""
        return "mix"

    @property
    def bounding_radius(self) -> float:
        """Radius of the sphere about the centre of mass that encloses the largest object [m]."""
        return max(each.bounding_radius for each in self.object_models)

    @property
    def diameter(self) -> float:
        """Smallest width of the widest object [m]."""
        return max(each.diameter for each in self.object_models)

    @property
    def flank_radius(self) -> float:
        """Radius of the upright cylinder that encloses each object [m]."""
        return max(each.flank_radius for each in self.object_models)

    def assign_models(self, count: int) -> list[ObjectModel]:
        """Return the model of each of `count` objects."""
        return [self.object_models[index % len(self.object_models)] for index in range(count)]


Objects = ObjectModel | ObjectMix
"""Objects of a pile: equal ones or a mix."""


def object_model(name: str, mass: float | None = None, scale: float = 1.0, variant: str = "real") -> ObjectModel:
    """Return a model by name or file.

    Args:
        name: Name of a shipped model, or path of an object's TOML file.
        mass: Mass that replaces the model's [kg]; the restitution follows it.
        scale: Factor of all lengths [-].
        variant: Variant of the object's file.

    Raises:
        ConfigurationError: The name is not known, or the file or variant is invalid.
    """
    if is_file(name):
        found = read_object(Path(name), variant)
    elif name in OBJECT_MODELS:
        found = read_object(object_files()[name], variant) if variant != "real" else OBJECT_MODELS[name]
    else:
        remedy = remedy_for(name, OBJECT_MODELS, f"choose from {', '.join(OBJECT_MODELS)}")
        raise ConfigurationError(f"pile.object = {name!r} is not known; {remedy}")
    return (found if mass is None else found.with_mass(mass)).scaled(scale)


def objects_of(pile: PileConfig) -> Objects:
    """Return the object model of a scenario, or the mix of the models that it joins by `+`.

    Raises:
        ConfigurationError: A name, file or variant is invalid, `pile.count` does not fill the nets, or a mix contains
            an object with a net.
    """
    found = tuple(
        object_model(name, pile.mass, pile.scale, pile.variant).with_friction(pile.friction)
        for name in object_parts(pile.object)
    )
    if len(found) > 1:
        if tied := [each.name for each in found if each.net is not None]:
            raise ConfigurationError(f"pile.object: {tied[0]!r} is tied by nets, which cannot be mixed; leave it out")
        return ObjectMix(found)
    single = found[0]
    if single.net is not None and (left := pile.count % single.net.members):
        fewer, members = pile.count - left, single.net.members
        choice = f"{fewer} or {fewer + members}" if fewer else str(members)
        raise ConfigurationError(
            f"pile.count = {pile.count} counts single objects, and a net of {single.name!r} holds {members}; "
            f"make it {choice}"
        )
    return single
