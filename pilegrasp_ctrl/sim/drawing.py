"""The shapes of a compiled model, as a recording wants them."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from ..recording import Body, Shape
from .scene import Scene

_KINDS = {
    mujoco.mjtGeom.mjGEOM_SPHERE: "sphere",
    mujoco.mjtGeom.mjGEOM_CAPSULE: "capsule",
    mujoco.mjtGeom.mjGEOM_CYLINDER: "cylinder",
    mujoco.mjtGeom.mjGEOM_BOX: "box",
    mujoco.mjtGeom.mjGEOM_ELLIPSOID: "ellipsoid",
    mujoco.mjtGeom.mjGEOM_PLANE: "plane",
}
COLLISION_GROUP = 3


def drawn_bodies(scene: Scene) -> tuple[tuple[Body, ...], np.ndarray]:
    """Return the bodies that can be seen and their body ids (n,); collision-only geoms are left out."""
    model = scene.model
    bodies, ids = [], []
    for body in range(model.nbody):
        first = int(model.body_geomadr[body])
        shapes = tuple(
            Shape(
                **_outline(model, geom),
                position=model.geom_pos[geom].tolist(),
                quaternion=model.geom_quat[geom].tolist(),
                rgba=np.clip(model.geom_rgba[geom].astype(float), 0.0, 1.0).tolist(),
            )
            for geom in range(first, first + int(model.body_geomnum[body]))
            if model.geom_group[geom] != COLLISION_GROUP and model.geom_rgba[geom, 3] > 0.0
        )
        if shapes:
            bodies.append(Body(model.body(body).name, _role(scene, body), shapes))
            ids.append(body)
    return tuple(bodies), np.array(ids)


def _outline(model: Any, geom: int) -> dict[str, Any]:
    """Return kind and size; a recording knows no meshes, so a hull is drawn as the ellipsoid of the same inertia."""
    kind = mujoco.mjtGeom(int(model.geom_type[geom]))
    if kind != mujoco.mjtGeom.mjGEOM_MESH:
        return {"kind": _KINDS[kind], "size": model.geom_size[geom].tolist()}
    body = int(model.geom_bodyid[geom])
    inertia = model.body_inertia[body] / model.body_mass[body]
    return {"kind": "ellipsoid", "size": np.sqrt(2.5 * (inertia.sum() - 2.0 * inertia)).tolist()}


def _role(scene: Scene, body: int) -> str:
    if body == 0:
        return "support"
    if body in scene.objects:
        return "object"
    if body in scene.hand_bodies:
        return "sensor" if scene.model.body(body).name == "sensor" else "hand"
    return "arm"
