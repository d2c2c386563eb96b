"""The convex hull of a mesh, about its centre of mass and along its principal axes."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from ..exceptions import ConfigurationError
from ..files import MAX_MESH_SIZE, check_file

MAX_VERTICES = 200
"""Largest number of vertices of a hull [-], chosen; the time of a collision grows with their number."""

FORMATS = (".stl", ".obj")
"""File formats of a mesh."""

Triple = tuple[float, float, float]
_CONVEX = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX


def half_extents(vertices: Sequence[Triple]) -> Triple:
    """Return the half widths of points (n, 3) along their axes [m]."""
    x, y, z = (0.5 * np.ptp(np.array(vertices), axis=0)).tolist()
    return x, y, z


def bounding_radius(vertices: Sequence[Triple]) -> float:
    """Return the largest distance of points (n, 3) from the origin [m]."""
    return float(np.linalg.norm(vertices, axis=1).max())


@dataclass(frozen=True, slots=True)
class Hull:
    """A convex polyhedron. It holds tuples, so that it is comparable and hashable, and its `repr` is complete.

    Attributes:
        vertices: Vertices (n, 3) [m] about the centre of mass, along the principal axes.
        faces: Indices (m, 3) of the vertices.
        volume: Volume [m³].
        moments: Principal moments of inertia per mass of the homogeneous solid [m²].
    """

    vertices: tuple[Triple, ...]
    faces: tuple[tuple[int, int, int], ...]
    volume: float
    moments: Triple

    @classmethod
    def load(cls, file: Path, factor: float) -> Hull:
        """Read the convex hull of an STL (binary) or OBJ file whose coordinates times `factor` are metres.

        Raises:
            ConfigurationError: The file is missing, has another format, is damaged, or its hull has no volume.
        """
        if file.suffix.lower() not in FORMATS:
            raise ConfigurationError(f"{file}: a mesh must be one of {', '.join(FORMATS)}")
        if not os.path.exists(file):
            raise ConfigurationError(f"{file}: no such mesh; its path is relative to the object's file")
        check_file(file, MAX_MESH_SIZE, "of a mesh")
        spec = mujoco.MjSpec()
        spec.add_mesh(
            name="mesh", file=str(file.resolve()), scale=[factor] * 3, maxhullvert=MAX_VERTICES, inertia=_CONVEX
        )
        return cls._compile(spec, str(file))

    @classmethod
    def _compile(cls, spec: mujoco.MjSpec, source: str) -> Hull:
        """Return the hull that MuJoCo computes for the mesh in `spec`; `source` names the mesh in an error."""
        spec.worldbody.add_body().add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="mesh", density=1.0)
        try:
            model = spec.compile()
        except ValueError as error:
            why = str(error).splitlines()[0].removeprefix("Error: ")
            raise ConfigurationError(
                f"{source}: cannot be used as a mesh; it must be a body with a volume in binary STL or OBJ: {why}"
            ) from None
        graph, vertices = model.mesh_graph, np.asarray(model.mesh_vert, dtype=float)
        count, faces = int(graph[0]), int(graph[1])
        kept = graph[2 + count : 2 + 2 * count]
        triangles = graph[2 + 3 * count + 3 * faces : 2 + 3 * count + 6 * faces].reshape(-1, 3)
        local = {int(index): i for i, index in enumerate(kept)}
        volume = float(model.body_mass[1])
        return cls(
            vertices=tuple(tuple(row) for row in vertices[kept].tolist()),
            faces=tuple(tuple(local[int(index)] for index in row) for row in triangles),  # type: ignore[misc]
            volume=volume,
            moments=tuple((model.body_inertia[1] / volume).tolist()),
        )

    def scaled(self, factor: float) -> Hull:
        """Return the hull with its lengths multiplied."""
        vertices = tuple((factor * x, factor * y, factor * z) for x, y, z in self.vertices)
        a, b, c = (factor**2 * moment for moment in self.moments)
        return Hull(vertices, self.faces, math.pow(factor, 3) * self.volume, (a, b, c))

    @property
    def half_extents(self) -> Triple:
        """Half widths along the principal axes [m]."""
        return half_extents(self.vertices)

    @property
    def bounding_radius(self) -> float:
        """Radius of the enclosing sphere about the centre of mass [m]."""
        return bounding_radius(self.vertices)

    def add_to(self, spec: mujoco.MjSpec, name: str) -> None:
        """Add the hull to `spec` as a mesh, unless it is already there."""
        if spec.mesh(name) is None:
            spec.add_mesh(
                name=name,
                uservert=np.ravel(self.vertices).tolist(),
                userface=np.ravel(self.faces).tolist(),
                inertia=_CONVEX,
            )
