"""A bounce at the shipped step against the same bounce at half of it."""

from __future__ import annotations

from collections.abc import Iterator

from ...sim.hand import Hand
from ...sim.objects import OBJECT_MODELS
from .contact_rig import SHIPPED_STEP, ContactRig
from .physics_check import PhysicsCheck
from .restitution import TOLERANCE, drops


def step_halving_checks() -> Iterator[PhysicsCheck]:
    """Check that half the step gives the same restitution: requested is what the half step measured."""
    hand = Hand.load("shovel")
    for name in ("light_sphere", "heavy_sphere", "cube"):
        half, shipped = (
            drops(ContactRig.build(OBJECT_MODELS[name], hand, step), "table")
            for step in (0.5 * SHIPPED_STEP, SHIPPED_STEP)
        )
        words = f"half step: restitution of {name.replace('_', ' ')} on table"
        yield PhysicsCheck(words, float(half.values.mean()), float(shipped.values.mean()), TOLERANCE, "-")
