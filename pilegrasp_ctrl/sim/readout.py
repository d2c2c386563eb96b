"""Readout of a running simulation: drawn bodies and the forces between them."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from ..recording_parts import Body, Shape
from ..types import Array
from ..vectors import rotated
from .object_model import COLLISION_GROUP
from .scene import Scene

SHAPE_NAMES = {
    mujoco.mjtGeom.mjGEOM_SPHERE: "sphere",
    mujoco.mjtGeom.mjGEOM_CAPSULE: "capsule",
    mujoco.mjtGeom.mjGEOM_CYLINDER: "cylinder",
    mujoco.mjtGeom.mjGEOM_BOX: "box",
    mujoco.mjtGeom.mjGEOM_ELLIPSOID: "ellipsoid",
    mujoco.mjtGeom.mjGEOM_PLANE: "plane",
}
"""Names of MuJoCo's geom types in a recording."""

MIN_FORCE = 0.1
"""Least force of a recorded contact [N], chosen; a light sphere weighs 0.6 N."""

ROLE_ORDER = {"arm": 0, "sensor": 0, "hand": 0, "object": 1, "support": 2}
"""Order of two bodies in a contact, by role: the one nearer to the arm comes first."""


def drawn_bodies(scene: Scene) -> tuple[tuple[Body, ...], np.ndarray]:
    """Return the drawn bodies and their body ids (n,), without geoms that only collide."""
    model = scene.model
    bodies, ids = [], []
    for body in range(model.nbody):
        first = int(model.body_geomadr[body])
        shapes = tuple(
            Shape(
                **_shape_of(model, geom),
                position=model.geom_pos[geom].tolist(),
                quaternion=model.geom_quat[geom].tolist(),
                rgba=np.clip(model.geom_rgba[geom].astype(float), 0.0, 1.0).tolist(),
            )
            for geom in range(first, first + int(model.body_geomnum[body]))
            if model.geom_group[geom] != COLLISION_GROUP and model.geom_rgba[geom, 3] > 0.0
        )
        if shapes:
            bodies.append(Body(model.body(body).name, _role_of(scene, body), shapes))
            ids.append(body)
    return tuple(bodies), np.array(ids)


def _shape_of(model: Any, geom: int) -> dict[str, Any]:
    """Return `kind` and `size` of a `Shape`, and vertices and faces of a mesh."""
    geom_type = mujoco.mjtGeom(int(model.geom_type[geom]))
    if geom_type != mujoco.mjtGeom.mjGEOM_MESH:
        return {"kind": SHAPE_NAMES[geom_type], "size": model.geom_size[geom].tolist()}
    mesh = int(model.geom_dataid[geom])
    first, corner = int(model.mesh_vertadr[mesh]), int(model.mesh_faceadr[mesh])
    vertices = model.mesh_vert[first : first + int(model.mesh_vertnum[mesh])].astype(float)
    faces = model.mesh_face[corner : corner + int(model.mesh_facenum[mesh])]
    size = np.abs(vertices).max(axis=0)
    return {"kind": "mesh", "size": size.tolist(), "vertices": np.round(vertices, 6).tolist(), "faces": faces.tolist()}


def _role_of(scene: Scene, body: int) -> str:
    """Return the role of a body in a recording."""
    if body == 0:
        return "support"
    if body in scene.objects:
        return "object"
    if body in scene.hand_bodies:
        return "sensor" if scene.model.body(body).name == "sensor" else "hand"
    return "arm"


class ContactForces:
    """Reads the contacts between drawn bodies.

    The first body of a pair is the one nearer to the arm: the hand before an object, an object before a support.
    """

    def __init__(self, model: Any, bodies: tuple[Body, ...], ids: NDArray[np.int_]) -> None:
        """Read the contacts of `model` between `bodies`, whose body ids are `ids`."""
        self._model = model
        index_of = {int(body): index for index, body in enumerate(ids)}
        drawn = []
        for geom in range(model.ngeom):
            body = int(model.geom_bodyid[geom])
            while body not in index_of and body:
                body = int(model.body_parentid[body])
            drawn.append(index_of.get(body, 0))
        self._body = np.array(drawn, dtype=np.int32)
        self._order = np.array([ROLE_ORDER[body.role] for body in bodies])

    def read(self, data: Any) -> tuple[NDArray[np.int32], Array, Array]:
        """Return bodies (K, 2), positions (K, 3) [m] and forces (K, 3) [N] on the first body, in world axes.

        Contacts of bodies that sleep are missing, because MuJoCo does not compute them.
        """
        contact = data.contact
        active = np.flatnonzero(contact.efc_address >= 0)
        local = np.zeros((active.size, 6))
        for row, index in zip(local, active, strict=True):
            mujoco.mj_contactForce(self._model, data, int(index), row)
        pressing = np.linalg.norm(local[:, :3], axis=1) >= MIN_FORCE
        active, local = active[pressing], local[pressing]
        # The rows of a contact's frame are its axes. The first is the normal from the first geom to the second, and a
        # positive force pushes the second geom along it.
        axes = contact.frame[active].reshape(-1, 3, 3)
        force = -rotated(np.swapaxes(axes, 1, 2), local[:, :3])
        bodies = self._body[contact.geom[active]].reshape(-1, 2)
        swapped = self._order[bodies[:, 0]] > self._order[bodies[:, 1]]
        bodies[swapped] = bodies[swapped][:, ::-1]
        force[swapped] *= -1.0
        return bodies, contact.pos[active].copy(), force


class SceneReadout:
    """The `SceneView` of a MuJoCo scene.

    Attributes:
        bodies: Drawn bodies.
    """

    def __init__(self, scene: Scene, data: mujoco.MjData) -> None:
        """Read the bodies of `scene` from its state `data`."""
        self._data = data
        self.bodies, self._ids = drawn_bodies(scene)
        self._contact_forces = ContactForces(scene.model, self.bodies, self._ids)

    def poses(self) -> tuple[Array, Array]:
        """Return positions (B, 3) [m] and quaternions wxyz (B, 4) of the bodies, as of the last physics step."""
        # An array of indices makes a copy.
        return self._data.xpos[self._ids], self._data.xquat[self._ids]

    def contacts(self) -> tuple[NDArray[np.int32], Array, Array]:
        """Return bodies (K, 2), positions (K, 3) [m] and forces (K, 3) [N] of the contacts; see `ContactForces`."""
        return self._contact_forces.read(self._data)
