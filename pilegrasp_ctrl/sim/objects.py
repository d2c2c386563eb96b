"""The objects of a pile: shipped models, models of a user, and mixes of several models."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..exceptions import ConfigurationError, remedy_for
from ..planning.layout import frame_size
from ..scenarios import is_file, object_files, object_parts
from ..sections import PileConfig
from .object_file import read_object
from .object_model import ObjectModel

PAPER_WIDTH = 0.054
"""Width of the paper's spheres, for which its frames are stated [m]."""

MAX_FRAME = 0.6
"""Largest side of a frame that is not stated [m]; chosen, for large parts."""

MAX_LAYERS = 4
"""Largest number of layers in which objects of a file drop into a frame that is not stated [-]; chosen."""

COLUMN_WIDTH = 2.1
"""Width of a column of dropping objects, over their bounding radius [-]: above the spacings of `sim/drop.py`."""

SPREAD_STREAM = 0x5B
"""Number that sets the generator of the spread apart from that of the drop, which has the seed alone."""

OBJECT_MODELS = {name: read_object(file) for name, file in object_files().items()}
"""Shipped models by name, in the variant "real"."""


@dataclass(frozen=True, slots=True)
class ObjectMix:
    """Several models in turn: object i has model i modulo their number. No model has a net.

    Attributes:
        object_models: Models in turn; a model that is named twice is twice as frequent.
        shape: Shape of the objects; "mix" if they are not of one kind.
    """

    object_models: tuple[ObjectModel, ...]
    shape: str = "mix"

    @property
    def net(self) -> None:
        """Net of the objects: None for a mix."""
        return None

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


def own_frame(pile: PileConfig, objects: Objects) -> float | None:
    """Return the side of the dropping frame of objects of a user's file [m]; None for objects that ship.

    The paper states its frames for its own objects. Others have a frame that grows with their number and their mean
    width, so that a pile of screws and a pile of boxes are piles, and in which they drop in at most `MAX_LAYERS`.
    """
    parts = object_parts(pile.object)
    if pile.frame_size is not None or not pile.count or not any(map(is_file, parts)):
        return None
    widths = [
        _mean_width(model) if is_file(part) else PAPER_WIDTH
        for part, model in zip(parts, objects.assign_models(len(parts)), strict=True)
    ]
    columns = math.ceil(math.sqrt(pile.count / MAX_LAYERS))
    side = max(frame_size(pile) * max(widths) / PAPER_WIDTH, columns * COLUMN_WIDTH * objects.bounding_radius)
    return min(side, MAX_FRAME)


def _mean_width(model: ObjectModel) -> float:
    """Return the geometric mean of a model's three widths [m]."""
    a, *rest = model.half_size
    second, third = rest if len(rest) == 2 else (rest[0], a) if rest else (a, a)
    return 2.0 * math.cbrt(a * second * third)


def spread(objects: Objects, pile: PileConfig, seed: int) -> Objects:
    """Return the objects with sizes, masses and frictions that differ within `pile.spread`, drawn from the seed.

    Raises:
        ConfigurationError: The objects are tied by nets.
    """
    wide = pile.spread
    if not (wide.size or wide.mass or wide.friction) or not pile.count:
        return objects
    if objects.net is not None:
        raise ConfigurationError("pile.spread is for single objects, and those of a net are alike; leave it out")
    rng = np.random.default_rng([seed, SPREAD_STREAM])
    factors = 1.0 + rng.uniform(-1.0, 1.0, size=(pile.count, 3)) * [wide.size, wide.mass, wide.friction]
    varied = tuple(
        replace(each.scaled(size).with_mass(mass * each.mass).with_friction(friction), name=f"{each.name}~{index}")
        for index, (each, (size, mass, friction)) in enumerate(
            zip(objects.assign_models(pile.count), factors.tolist(), strict=True)
        )
    )
    return ObjectMix(varied, objects.shape)


def objects_of(pile: PileConfig) -> Objects:
    """Return the object model of a scenario, or the mix of the models that it joins by `+`.

    Raises:
        ConfigurationError: A name, file or variant is invalid, `pile.count` does not fill the nets, or a mix contains
            an object with a net.
    """
    found = tuple(
        object_model(name, pile.mass, pile.scale, pile.variant)
        .with_sliding_friction(pile.friction_value)
        .with_friction(pile.friction)
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
