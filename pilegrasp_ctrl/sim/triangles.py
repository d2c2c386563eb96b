"""A closed mesh of triangles: read, checked, and integrated exactly."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from ..exceptions import ConfigurationError
from ..files import MAX_MESH_SIZE, read_file
from ..types import Array
from ..vectors import components, rotated

FORMATS = (".stl", ".obj")
"""File formats of a mesh."""

MAX_TRIANGLES = 200_000
"""Largest number of triangles of a mesh [-]; chosen: that many are decomposed in minutes."""

FLAT = 1e-4
"""Least volume of a solid over that of the box around it [-]; chosen. A flatter mesh is a sheet, not a body."""


@dataclass(frozen=True, slots=True, eq=False)
class Triangles:
    """A closed surface whose triangles are anticlockwise seen from outside.

    Attributes:
        vertices: (n, 3) vertices [m].
        faces: (m, 3) indices of the vertices.
        volume: Volume [m³].
        center: (3,) centre of mass of the homogeneous solid [m].
        inertia: (3, 3) inertia about it, per mass [m²].
    """

    vertices: Array
    faces: NDArray[np.int64]
    volume: float
    center: Array
    inertia: Array

    def principal_axes(self) -> tuple[Array, tuple[float, float, float]]:
        """Return the rotation (3, 3) whose columns are the principal axes, and the principal moments per mass [m²]."""
        moments, axes, quaternion = np.zeros(3), np.zeros(9), np.zeros(4)
        mujoco.mju_eig3(moments, axes, quaternion, np.ascontiguousarray(self.inertia).ravel())
        first, second, third = moments.tolist()
        return axes.reshape(3, 3), (first, second, third)


def read_triangles(file: Path, factor: float) -> Triangles:
    """Read an STL or OBJ file whose coordinates times `factor` are metres.

    Raises:
        ConfigurationError: The file is missing, damaged or too large, or its mesh is not the surface of a body.
    """
    if file.suffix.lower() not in FORMATS:
        raise ConfigurationError(f"{file}: a mesh must be one of {', '.join(FORMATS)}")
    if not file.exists():
        raise ConfigurationError(f"{file}: no such mesh; its path is relative to the object's file")
    content = read_file(file, MAX_MESH_SIZE, "of a mesh")
    vertices, faces = _parse(content, file)
    try:
        return close(factor * vertices, faces)
    except ConfigurationError as error:
        raise ConfigurationError(f"{file}: {error}") from None


def _parse(content: bytes, file: Path) -> tuple[Array, NDArray[np.int64]]:
    """Return vertices (n, 3) and faces (m, 3) of a file's content, with equal vertices merged."""
    import trimesh

    kind = file.suffix.lower().removeprefix(".")
    options: dict[str, Any] = {"skip_materials": True} if kind == "obj" else {}
    try:
        # Without a resolver, a file can name no other file.
        mesh = trimesh.load_mesh(io.BytesIO(content), file_type=kind, process=False, **options)
        vertices, faces = np.array(mesh.vertices, dtype=np.float64), np.array(mesh.faces, dtype=np.int64)
    except Exception as error:  # trimesh raises a dozen unrelated types for damaged files
        raise ConfigurationError(f"{file}: cannot be read as {kind.upper()}: {type(error).__name__}") from None
    if not len(faces) or faces.ndim != 2 or vertices.ndim != 2:
        raise ConfigurationError(f"{file}: cannot be used as a mesh: it has no triangles")
    if len(faces) > MAX_TRIANGLES:
        raise ConfigurationError(
            f"{file}: has {len(faces)} triangles, and {MAX_TRIANGLES} are allowed; reduce the mesh in your CAD program"
        )
    if not np.isfinite(vertices).all():
        raise ConfigurationError(f"{file}: cannot be used as a mesh: a vertex is not a finite number")
    merged, index = np.unique(vertices, axis=0, return_inverse=True)
    faces = index.reshape(-1)[faces]
    distinct = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    return merged, faces[distinct]


def close(vertices: Array, faces: NDArray[np.int64]) -> Triangles:
    """Return a checked mesh with its integrals; a surface that is inside out is turned.

    Raises:
        ConfigurationError: The surface is not closed, or has no volume.
    """
    if open_edges := _open_edges(np.sort(_edges(faces), axis=1), 2):
        raise ConfigurationError(
            f"the mesh is not the closed surface of a body: {open_edges} of its edges do not join two triangles; close "
            "it in your CAD program, or make hull = true"
        )
    if _open_edges(_edges(faces), 1):
        faces = _one_sense(faces)
    box = float(np.prod(np.ptp(vertices, axis=0)))
    volume, center, second = integrals(vertices, faces)
    if volume < 0.0:
        faces, volume, second = faces[:, ::-1], -volume, -second
    if not volume > FLAT * box:
        raise ConfigurationError("the mesh has no volume; it must be the closed surface of a body")
    inertia = (np.trace(second) * np.eye(3) - second) / volume
    return Triangles(vertices, faces, volume, center, inertia)


def _edges(faces: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the edges (3 m, 2) of triangles (m, 3), each with its sense."""
    return np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])


def _open_edges(edges: NDArray[np.int64], times: int) -> int:
    """Return how many different edges do not occur just so many `times`."""
    return int(np.count_nonzero(np.unique(edges, axis=0, return_counts=True)[1] != times))


def _one_sense(faces: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the triangles of closed surfaces with one sense: each is turned to fit a neighbour, from the first on."""
    neighbours: dict[tuple[int, int], list[int]] = {}
    for number, (a, b, c) in enumerate(faces.tolist()):
        for edge in ((a, b), (b, c), (c, a)):
            neighbours.setdefault((min(edge), max(edge)), []).append(number)
    turned, seen = faces.copy(), np.zeros(len(faces), dtype=bool)
    for first in range(len(faces)):
        waiting = [] if seen[first] else [first]
        seen[first] = True
        while waiting:
            number = waiting.pop()
            a, b, c = turned[number].tolist()
            for start, end in ((a, b), (b, c), (c, a)):
                for other in neighbours[min(start, end), max(start, end)]:
                    if not seen[other]:
                        seen[other] = True
                        x, y, z = turned[other].tolist()
                        if (start, end) in ((x, y), (y, z), (z, x)):
                            turned[other] = (x, z, y)
                        waiting.append(other)
    return turned


def integrals(vertices: Array, faces: NDArray[np.int64]) -> tuple[float, Array, Array]:
    """Return volume [m³], centre of mass (3,) [m], and the integral of x xᵀ about it (3, 3) [m⁵] of a polyhedron.

    The polyhedron is a signed sum of tetrahedra from one point to each triangle. Over a tetrahedron with a corner at
    the origin and the others at a, b and c, with s = a + b + c and d = det(a, b, c), the integrals are d / 6,
    d s / 24, and d (s sᵀ + a aᵀ + b bᵀ + c cᵀ) / 120 (Tonon 2004). They are exact but for rounding.
    """
    middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    a, b, c = (vertices[faces[:, corner]] - middle for corner in range(3))
    det = (a * np.cross(b, c)).sum(axis=1)
    total = a + b + c
    volume = float(det.sum()) / 6.0
    if volume == 0.0:
        return 0.0, middle, np.zeros((3, 3))
    center = (det[:, None] * total).sum(axis=0) / (24.0 * volume)
    second = np.zeros((3, 3))
    for row in range(3):
        for column in range(3):
            terms = total[:, row] * total[:, column]
            for corner in (a, b, c):
                terms = terms + corner[:, row] * corner[:, column]
            second[row, column] = float((det * terms).sum()) / 120.0
    return volume, center + middle, second - volume * np.outer(center, center)


def in_axes(points: Array, center: Array, axes: Array) -> Array:
    """Return points (n, 3) seen from `center` (3,) in the frame whose axes are the columns of `axes` (3, 3)."""
    return rotated(axes.T, points - center)


def width_along(points: Array, direction: Array) -> float:
    """Return the width of points (n, 3) along a unit vector (3,) [m]."""
    return float(np.ptp(components(points, direction)))
