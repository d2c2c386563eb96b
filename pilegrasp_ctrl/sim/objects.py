"""The objects of the paper's Table I, and a user's own: from the keys of `pile` to a kind."""

from __future__ import annotations

from difflib import get_close_matches
from pathlib import Path

from ..exceptions import ConfigurationError
from ..scenarios import is_file, object_files, object_parts
from ..sections import PileConfig
from .object_file import read_object
from .object_mix import ObjectMix, Objects
from .object_model import OBJECT_BIT, SMOOTH, ObjectModel
from .restitution import restitution_for_mass

__all__ = ["OBJECT_BIT", "OBJECT_MODELS", "SMOOTH", "ObjectModel", "object_model", "objects_of", "restitution_for_mass"]

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
