"""Balls whose hull holds the collision geometry of each link of a model."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import product
from math import cos, pi, sin
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

from ..exceptions import ModelError
from ..files import resolved
from ..types import Array, rotation_matrices
from ..vectors import rotated
from .mjcf_couplings import enum_values

_SIDES = 24
"""Number of sides of the prism around a round shape; chosen: it is at most 1 % wider than the shape."""


class Balls(NamedTuple):
    """Balls whose hull holds a shape: centres (n, 3) and radii (n,), zero for corners [m]."""

    centers: Array
    radii: Array

    def moved(self, rotation: Array, translation: Array) -> Balls:
        """Return the balls in the frame in which theirs has this pose."""
        return Balls(rotated(rotation, self.centers) + translation, self.radii)


def balls_of_model(source: Any, folders: Iterable[str | PathLike[str]], above: bool = True) -> dict[str, Balls]:
    """Return balls around the collision geometry of each link, in the link's frame, by the link's name.

    Args:
        source: A URDF or MJCF file, a `mujoco.MjModel` or a `mujoco.MjSpec`.
        folders: Folders that hold the packages of a URDF's meshes.
        above: Whether the folders above the URDF count as well.

    Raises:
        ModelError: The source cannot be read, or a mesh is missing.
    """
    if type(source).__module__.partition(".")[0] == "mujoco":
        return _of_mjcf(source)
    try:
        file = Path(source)
        root = ElementTree.parse(file).getroot()
    except (ElementTree.ParseError, LookupError, ValueError) as error:
        raise ModelError(f"{source}: not a URDF or MJCF file, because it is not XML: {error}") from None
    except (OSError, TypeError):
        raise ModelError(f"{source!s:.80}: no such URDF or MJCF file; give the path of an existing one") from None
    if root.tag == "mujoco":
        return _of_mjcf(file)
    parents = [str(folder) for folder in resolved(file, ModelError).parents] if above else []
    return _of_urdf(file, [*map(str, folders), *parents])


def _of_urdf(file: Path, folders: list[str]) -> dict[str, Balls]:
    try:
        model = pin.buildModelFromUrdf(str(file))
        shapes = pin.buildGeomFromUrdf(model, str(file), pin.GeometryType.COLLISION, package_dirs=folders)
    except (ValueError, RuntimeError) as error:
        raise ModelError(
            f"{file}: its collision geometry cannot be read; give folders=[...] that hold its packages, or state "
            f"capsules: {' '.join(str(error).split())}"
        ) from None
    found: dict[str, list[Balls]] = {}
    for shape in shapes.geometryObjects:
        frame = model.frames[shape.parentFrame]
        place = frame.placement.inverse() * shape.placement
        found.setdefault(frame.name, []).append(_of_shape(shape.geometry).moved(place.rotation, place.translation))
    return _joined(found)


def _of_shape(shape: Any) -> Balls:
    """Return balls around a shape of Pinocchio's geometry."""
    kind = type(shape).__name__
    if kind == "Box":
        return _box(shape.halfSide)
    if kind == "Sphere":
        return _swept(shape.radius, 0.0)
    if kind == "Capsule":
        return _swept(shape.radius, shape.halfLength)
    if kind in ("Cylinder", "Cone"):
        return _round(shape.radius, shape.halfLength)
    return _corners(shape.vertices())


def _of_mjcf(source: Any) -> dict[str, Balls]:
    import mujoco

    try:
        if isinstance(source, mujoco.MjModel):
            mj = source
        else:
            spec = source.copy() if isinstance(source, mujoco.MjSpec) else mujoco.MjSpec.from_file(str(source))
            mj = spec.compile()
    except (ValueError, RuntimeError) as error:
        why = " ".join(str(error).split())
        raise ModelError(f"{source!s:.80}: not a model that MuJoCo can compile: {why}") from None
    found: dict[str, list[Balls]] = {}
    for geom in range(mj.ngeom):
        balls = _of_geom(mj, geom) if mj.geom_contype[geom] or mj.geom_conaffinity[geom] else None
        body = mj.body(int(mj.geom_bodyid[geom]))
        if balls is not None and body.id > 0 and body.name:
            found.setdefault(body.name, []).append(
                balls.moved(rotation_matrices(mj.geom_quat[geom]), mj.geom_pos[geom])
            )
    return _joined(found)


def _of_geom(mj: Any, geom: int) -> Balls | None:
    """Return balls around a geom of MuJoCo, in its frame; None for one without bounds, such as a plane."""
    names = ("SPHERE", "CAPSULE", "ELLIPSOID", "CYLINDER", "BOX", "MESH")
    kinds = dict(zip(enum_values("mjtGeom", *(f"mjGEOM_{name}" for name in names)), names, strict=True))
    kind, (x, y, _) = kinds.get(int(mj.geom_type[geom])), mj.geom_size[geom].tolist()
    if kind == "MESH":
        mesh = int(mj.geom_dataid[geom])
        first, count = int(mj.mesh_vertadr[mesh]), int(mj.mesh_vertnum[mesh])
        return _corners(mj.mesh_vert[first : first + count])
    if kind in ("BOX", "ELLIPSOID"):
        return _box(mj.geom_size[geom])
    if kind in ("SPHERE", "CAPSULE"):
        return _swept(x, y if kind == "CAPSULE" else 0.0)
    return _round(x, y) if kind == "CYLINDER" else None


def _joined(found: dict[str, list[Balls]]) -> dict[str, Balls]:
    return {
        link: Balls(*(np.concatenate(parts) for parts in zip(*balls, strict=True))) for link, balls in found.items()
    }


def _corners(points: Any) -> Balls:
    centers = np.array(points, dtype=np.float64)
    return Balls(centers, np.zeros(len(centers)))


def _box(half: Array) -> Balls:
    return _corners(np.array(list(product((-1.0, 1.0), repeat=3))) * half)


def _round(radius: float, half_length: float) -> Balls:
    """Return the corners of a prism around a cylinder along z."""
    outer = radius / cos(pi / _SIDES)
    turns = [2.0 * pi * side / _SIDES for side in range(_SIDES)]
    return _corners([[outer * cos(t), outer * sin(t), z] for z in (-half_length, half_length) for t in turns])


def _swept(radius: float, half_length: float) -> Balls:
    """Return the balls at the ends of a capsule along z."""
    return Balls(np.array([[0.0, 0.0, -half_length], [0.0, 0.0, half_length]]), np.full(2, radius))
