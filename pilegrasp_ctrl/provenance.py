"""What a result rests on: versions of packages, and the code of the rooms that decide it."""

from __future__ import annotations

ROOMS: tuple[tuple[str, ...], ...] = (
    ("types", "exceptions", "files", "config", "sections", "provenance", "statistics", "robots", "scenarios"),
    ("kernels",),
    ("arm",),
    ("tasks", "limits", "qp"),
    ("control",),
    ("trajectories", "primitives", "planning", "plant"),
    ("recording", "contacts", "analysis"),
    ("sim",),
    ("recorder", "episode", "programs"),
    ("viewer",),
    ("study", "tuning", "search", "validation"),
    ("cli", "scripts", "__init__"),
)
"""Rooms and files of the package, lowest first: a room imports from its own row and from the rows above it. `scenarios`
and `robots` are the finders alone; what runs in `scenarios/` belongs to `scripts`."""

DECIDING_ROOMS = tuple(room for row in ROOMS[: ROOMS.index(("viewer",))] for room in row)
"""Rooms whose code decides the result of an attempt."""
