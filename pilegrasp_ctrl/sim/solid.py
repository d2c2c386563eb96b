"""A body from a mesh that is not convex: drawn as it is, and touched as a union of convex pieces."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass, field, replace
from pathlib import Path

import mujoco
import numpy as np

from ..files import MAX_MESH_SIZE, read_file
from ..types import Array
from .hull import Hull, Triple, bounding_radius, half_extents
from .pieces import cached_pieces, pieces_path, read_pieces
from .triangles import Triangles, in_axes, read_triangles

CONVEX = 0.99
"""Volume of a mesh over that of its hull from which it counts as convex [-]; chosen."""

MAX_DRAWN = 5000
"""Largest number of triangles of a drawn surface [-]; chosen for the size of a page. Instead of a finer surface, the
pieces are drawn."""


@dataclass(frozen=True, slots=True)
class Solid:
    """A polyhedron about its centre of mass and along its principal axes, with the convex pieces that stand for it.

    Attributes:
        vertices: Vertices (n, 3) of the surface [m].
        faces: Indices (m, 3) of the vertices; empty for a surface that is too fine to be drawn.
        pieces: Vertices (k, 3) of each convex piece [m].
        volume: Volume of the polyhedron [m³].
        moments: Its principal moments of inertia per mass [m²].
        stored: Whether the pieces are stored beside the mesh; otherwise they were made on this machine.
    """

    vertices: tuple[Triple, ...]
    faces: tuple[tuple[int, int, int], ...]
    pieces: tuple[tuple[Triple, ...], ...]
    volume: float
    moments: Triple
    stored: bool = field(default=True, compare=False, repr=False)

    def scaled(self, factor: float) -> Solid:
        """Return the solid with its lengths multiplied."""
        a, b, c = (factor**2 * moment for moment in self.moments)
        return replace(
            self,
            vertices=_times(factor, self.vertices),
            pieces=tuple(_times(factor, piece) for piece in self.pieces),
            volume=math.pow(factor, 3) * self.volume,
            moments=(a, b, c),
        )

    @property
    def half_extents(self) -> Triple:
        """Half widths along the principal axes [m]."""
        return half_extents(self.vertices)

    @property
    def bounding_radius(self) -> float:
        """Radius of the enclosing sphere about the centre of mass [m]."""
        return bounding_radius(self.vertices)

    def add_to(self, spec: mujoco.MjSpec, name: str) -> None:
        """Add the pieces to `spec` as the meshes `name`, `name_1` ..., and the surface as `name_drawn`, once."""
        if spec.mesh(name) is not None:
            return
        for index, piece in enumerate(self.pieces):
            spec.add_mesh(
                name=f"{name}_{index}" if index else name,
                uservert=np.ravel(piece).tolist(),
                inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX,
            )
        if self.faces:
            spec.add_mesh(
                name=f"{name}_drawn",
                uservert=np.ravel(self.vertices).tolist(),
                userface=np.ravel(self.faces).tolist(),
                inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
            )


def load_solid(file: Path, factor: float) -> Hull | Solid:
    """Read an STL or OBJ file whose coordinates times `factor` are metres: a hull if it is convex.

    Raises:
        ConfigurationError: The file is missing or damaged, its mesh is not the closed surface of a body, or it cannot
            be decomposed.
    """
    mesh = read_triangles(file, factor)
    hull = Hull.load(file, factor)
    if mesh.volume >= CONVEX * hull.volume:
        return hull
    digest, beside = mesh_digest(file), pieces_path(file)
    stored = beside.is_file()
    # Stored pieces are in the unit of the file.
    pieces = read_pieces(beside, digest) if stored else cached_pieces(_in_file_unit(mesh, factor), digest, str(file))
    return build_solid(mesh, [factor * piece for piece in pieces], stored)


def build_solid(mesh: Triangles, pieces: list[Array], stored: bool) -> Solid:
    """Return the solid of a mesh and its pieces, which are in the same axes [m]."""
    axes, moments = mesh.principal_axes()
    drawn = len(mesh.faces) <= MAX_DRAWN
    return Solid(
        vertices=_tuples(in_axes(mesh.vertices, mesh.center, axes)),
        faces=tuple(tuple(face) for face in mesh.faces.tolist()) if drawn else (),  # type: ignore[misc]
        pieces=tuple(_tuples(in_axes(piece, mesh.center, axes)) for piece in pieces),
        volume=mesh.volume,
        moments=moments,
        stored=stored,
    )


def mesh_digest(file: Path) -> str:
    """Return the SHA-256 digest of a mesh file, which stored pieces name.

    Raises:
        ConfigurationError: The file cannot be read.
    """
    return hashlib.sha256(read_file(file, MAX_MESH_SIZE, "of a mesh")).hexdigest()


def _in_file_unit(mesh: Triangles, factor: float) -> Triangles:
    return replace(mesh, vertices=mesh.vertices / factor)


def _tuples(points: Array) -> tuple[Triple, ...]:
    return tuple((x, y, z) for x, y, z in points.tolist())


def _times(factor: float, points: tuple[Triple, ...]) -> tuple[Triple, ...]:
    return tuple((factor * x, factor * y, factor * z) for x, y, z in points)
