"""A picture of planned poses: the scene from the side and from above at each of them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from ...exceptions import ExportError
from ...sim.scene import Scene
from ...types import Array
from ...vectors import rotated

SIDES = 24
"""Number of points around a round shape [-]; chosen."""

COLLISION_GROUP = 3
"""MuJoCo's geom group of shapes that are not drawn."""

VIEWS = (("from the side", 0, 2), ("from above", 0, 1))
"""Title and axes of the views."""


def draw_poses(scene: Scene, state: mujoco.MjData, postures: Mapping[str, Array], file: Path) -> None:
    """Write a picture with a column for each posture.

    Args:
        scene: Compiled scene.
        state: State with the settled pile.
        postures: Postures (nv,) of the arm by name [rad].
        file: Picture to write, such as F.png.

    Raises:
        ExportError: The file cannot be written.
    """
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt
    from scipy.spatial import ConvexHull, QhullError

    figure, axes = plt.subplots(2, len(postures), figsize=(5.0 * len(postures), 8.0), squeeze=False)
    for column, (name, q) in enumerate(postures.items()):
        data = mujoco.MjData(scene.model)
        data.qpos[:] = state.qpos
        data.qpos[: scene.arm_dofs] = q
        mujoco.mj_forward(scene.model, data)
        for row, (view, across, up) in enumerate(VIEWS):
            place = axes[row][column]
            for points, color, alpha in _outlines(scene.model, data):
                flat = points[:, [across, up]]
                try:
                    flat = flat[ConvexHull(flat).vertices]
                except QhullError:
                    continue
                place.fill(*flat.T, facecolor=color, alpha=alpha, edgecolor="0.25", linewidth=0.6)
            if up == 2:
                place.axhline(0.0, color="0.4", linewidth=1.0)
            place.set_aspect("equal")
            place.set_title(f"{name}, {view}")
            place.set_xlabel("x [m]")
            place.set_ylabel(f"{'xyz'[up]} [m]")
    figure.tight_layout()
    try:
        figure.savefig(file, dpi=110)
    except (OSError, ValueError) as error:
        raise ExportError(f"{file}: cannot be written: {error}") from None
    finally:
        plt.close(figure)


def _outlines(model: Any, data: Any) -> Iterator[tuple[Array, tuple[float, ...], float]]:
    """Yield points (n, 3) whose hull is a drawn geom, its colour and its opacity."""
    for geom in range(model.ngeom):
        kind, rgba = mujoco.mjtGeom(int(model.geom_type[geom])), model.geom_rgba[geom].astype(float)
        if kind == mujoco.mjtGeom.mjGEOM_PLANE or rgba[3] == 0.0 or model.geom_group[geom] == COLLISION_GROUP:
            continue
        local = _points(model, geom)
        points = data.geom_xpos[geom] + rotated(data.geom_xmat[geom].reshape(3, 3), local)
        yield points, tuple(np.clip(rgba[:3], 0.0, 1.0)), 0.35 if rgba[3] < 1.0 else 0.8


def _points(model: Any, geom: int) -> Array:
    kind, size = mujoco.mjtGeom(int(model.geom_type[geom])), model.geom_size[geom]
    turns = np.array([2.0 * math.pi * side / SIDES for side in range(SIDES)])
    ring = np.column_stack([np.cos(turns), np.sin(turns), 0.0 * turns])
    if kind in (mujoco.mjtGeom.mjGEOM_SPHERE, mujoco.mjtGeom.mjGEOM_CAPSULE, mujoco.mjtGeom.mjGEOM_ELLIPSOID):
        radii = size if kind == mujoco.mjtGeom.mjGEOM_ELLIPSOID else np.full(3, size[0])
        half = size[1] if kind == mujoco.mjtGeom.mjGEOM_CAPSULE else 0.0
        ball = np.vstack([ring * radii, ring[:, [2, 0, 1]] * radii, ring[:, [0, 2, 1]] * radii])
        end = np.array([0.0, 0.0, half])
        return np.vstack([ball + end, ball - end])
    if kind == mujoco.mjtGeom.mjGEOM_CYLINDER:
        return np.vstack([ring * size[0] + np.array([0.0, 0.0, z]) for z in (-size[1], size[1])])
    center, half_size = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
    return center + half_size * np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
