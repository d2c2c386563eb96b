"""Notes on an attempt: what its result rests on, in sentences."""

from __future__ import annotations

from ..sim.hand import Hand
from ..sim.objects import Objects
from ..sim.solid import Solid


def notes_on(hand: Hand, objects: Objects, count: int) -> tuple[str, ...]:
    """Return the notes on hand and objects: parts that are too heavy, and pieces that are not stored.

    Args:
        hand: Hand.
        objects: Objects of the pile.
        count: Number of objects.
    """
    models = objects.assign_models(count)
    notes = []
    solids = {each.name.partition("~")[0]: each.hull for each in models if isinstance(each.hull, Solid)}
    made = {name: solid for name, solid in solids.items() if not solid.stored}
    for name, solid in made.items():
        notes.append(
            f"{name}: {len(solid.pieces)} convex pieces were made on this machine; `pilegrasp check PART --write` "
            "stores them, so that another machine takes the same"
        )
    payload = hand.description.use.payload
    if payload is not None and models and (heaviest := max(each.mass for each in models)) > payload:
        notes.append(
            f"an object of {heaviest:g} kg is heavier than the {payload:g} kg that {hand.name} was measured to hold"
        )
    return tuple(notes)
