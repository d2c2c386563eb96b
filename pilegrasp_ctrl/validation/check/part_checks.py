"""Checks of a part: that its file can be read, what stands for it in a contact, and whether it fits the hands."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from ...exceptions import ConfigurationError
from ...scenarios import is_file, object_files
from ...sim.hand import Hand
from ...sim.object_file import read_object
from .part import check_part
from .registry import Finding, Subject, checks
from .subjects import MESH_SUFFIXES


def _file_of(subject: Subject) -> Path:
    """Return the object's file.

    Raises:
        ConfigurationError: The subject is a bare mesh.
    """
    path = Path(subject.name)
    if path.suffix.lower() in MESH_SUFFIXES:
        raise ConfigurationError(
            f"{path}: is a mesh; write an object's file with shape = 'mesh', file = '{path.name}', unit and mass"
        )
    return path if is_file(subject.name) or path.suffix == ".toml" else object_files()[subject.name]


@checks("part")
def part(subject: Subject) -> Iterator[Finding]:
    """Read the object, and say its size, its mass, and what its numbers rest on."""
    report = check_part(_file_of(subject))
    for about, sentence in zip(("size", "contacts", "restitution", "friction"), report.sentences, strict=True):
        yield Finding("fact", about, sentence)
    for warning in report.warnings:
        yield Finding("note", "density", warning)


@checks("part")
def hands_of_part(subject: Subject) -> Iterator[Finding]:
    """Say whether the part fits the hands that are asked for, and whether they were measured to hold it."""
    model = read_object(_file_of(subject))
    for name in subject.hands:
        hand = Hand.load(name)
        width, payload = 2.0 * hand.use.half_width, hand.description.use.payload
        if model.diameter > width:
            wide = f"{1000 * model.diameter:.0f} mm at its narrowest, and {hand.name} meets {1000 * width:.0f} mm"
            yield Finding("note", "hand", f"it is {wide}")
        if payload is None:
            yield Finding("note", "payload", f"nobody measured what {hand.name} holds")
        elif model.mass > payload:
            yield Finding(
                "note", "payload", f"{hand.name} was measured to hold {payload:g} kg, and it is {model.mass:g} kg"
            )
        else:
            yield Finding("fact", "payload", f"{hand.name} was measured to hold {payload:g} kg")
