"""Checks of a hand: that its model can be built, and what it weighs."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ...sim.hand import Hand
from .registry import Finding, Subject, checks


@checks("hand")
def hand(subject: Subject) -> Iterator[Finding]:
    """Build the hand, and say what it is."""
    name = subject.name.removeprefix("hands/")
    loaded = Hand.load(f"{name}/" if Path(name).is_dir() and "/" not in name else name)
    mass = loaded.mass_properties()
    outline = loaded.use.outline
    width = float((outline[:, 1] + outline[:, 3]).max() - (outline[:, 1] - outline[:, 3]).min())
    away = float(np.linalg.norm(loaded.transform_tool_to_flange.translation))
    yield Finding("fact", "mass", f"it weighs {mass.mass:.2f} kg with the wrist sensor")
    yield Finding("fact", "size", f"it is {1000 * width:.0f} mm wide, and its tool frame is {1000 * away:.0f} mm away")
    touching = ", ".join(loaded.contact_geoms)
    yield Finding("fact", "contacts", f"the geoms that touch objects and table are {touching}")
