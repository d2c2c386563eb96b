"""What the library makes of an object's file, in sentences, and the convex pieces that are stored beside its meshes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...files import read_toml
from ...sim.hull import Hull
from ...sim.object_file import VARIANTS, read_object
from ...sim.object_model import SMOOTH, ObjectModel
from ...sim.pieces import decompose, write_pieces
from ...sim.solid import CONVEX, Solid, mesh_digest
from ...sim.triangles import read_triangles

DENSITIES = (20.0, 20_000.0)
"""Range of plausible densities [kg/m³]: from foam to tungsten."""


@dataclass(frozen=True, slots=True)
class PartReport:
    """What is known about a part.

    Attributes:
        sentences: What the part is, and what its numbers rest on.
        warnings: What may be wrong; it does not prevent a run.
        written: Files that were written.
    """

    sentences: tuple[str, ...]
    warnings: tuple[str, ...]
    written: tuple[Path, ...]


def store_pieces(file: Path) -> list[Path]:
    """Decompose each mesh of an object's file that is not convex, and return the files of the stored pieces.

    Raises:
        ConfigurationError: The file or a mesh cannot be used.
    """
    return _store(read_toml(file, "of an object"), file)


def check_part(file: Path, write: bool = False) -> PartReport:
    """Read an object's file, and store the convex pieces of its meshes if `write`.

    Raises:
        ConfigurationError: The file or a mesh cannot be used.
    """
    table = read_toml(file, "of an object")
    written = _store(table, file) if write else []
    model = read_object(file)
    x, y, z = (2000.0 * half for half in _box(model))
    density = model.mass / model.volume
    sentences = [
        f"{model.name} is a {model.shape} of {x:.0f} x {y:.0f} x {z:.0f} mm, {1000.0 * model.mass:.0f} g, and "
        f"{density / 1000.0:.2f} g/cm³.",
        _body(model),
        f"Its restitution is {model.surface.restitution:.2f}, "
        + ("from its mass by the paper's line." if model.bounces_by_mass else "from its file."),
        f"Its sliding friction is {model.surface.lateral:g}, "
        + ("from its file." if model.surface.lateral != SMOOTH.lateral else "that of smooth wood (Cross 2002)."),
    ]
    warnings = []
    if not DENSITIES[0] <= density <= DENSITIES[1]:
        warnings.append(f"a density of {density:.3g} kg/m³ is that of no material; check mass, unit and scale")
    return PartReport(tuple(sentences), tuple(warnings), tuple(written))


def _store(table: dict[str, Any], file: Path) -> list[Path]:
    """Decompose each mesh of a file that is not convex, and return the files of the pieces."""
    written = []
    places = [table, *(table[name] for name in VARIANTS if isinstance(table.get(name), dict))]
    for place in places:
        name = place.get("file")
        if not isinstance(name, str) or place.get("hull", table.get("hull")) is True:
            continue
        path = file.parent / name
        mesh = read_triangles(path, 1.0)
        if mesh.volume >= CONVEX * Hull.load(path, 1.0).volume:
            continue
        written.append(write_pieces(path, decompose(mesh, str(path)), mesh_digest(path)))
    return written


def _box(model: ObjectModel) -> tuple[float, float, float]:
    """Return the half widths of the box around a model, along its own axes [m]."""
    a, *rest = model.half_size
    if model.shape in ("cylinder", "capsule"):
        return a, a, rest[0] + (a if model.shape == "capsule" else 0.0)
    return (a, rest[0], rest[1]) if len(rest) == 2 else (a, a, a)


def _body(model: ObjectModel) -> str:
    """Return the sentence on what stands for the body in a contact."""
    body = model.hull
    if body is None:
        return "Contacts take the shape itself."
    if isinstance(body, Solid):
        where = (
            "stored beside the mesh" if body.stored else ("made on this machine, and not stored; --write stores them")
        )
        return f"Contacts take {len(body.pieces)} convex pieces, {where}; the page draws the mesh."
    return f"Contacts and page take its convex hull of {len(body.vertices)} vertices."
