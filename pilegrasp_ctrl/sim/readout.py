"""What a simulation shows: the bodies that are drawn, the forces in their contacts, and frames while it runs."""

from __future__ import annotations

import math
from collections.abc import Callable
from time import perf_counter
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from ..recording import Body, Shape
from ..types import Array
from .backend import Simulation
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


SMALLEST = 0.1
"""Contacts that press less than this are left out [N]; a light sphere weighs 0.6 N."""

_RANK = {"arm": 0, "sensor": 0, "hand": 0, "object": 1, "support": 2}


class ContactForces:
    """Reads the contacts of a model whose drawn bodies are `bodies`, with the body ids `ids`.

    The first body of a pair is the one nearer to the arm: the hand before an object, an object before a support.
    """

    def __init__(self, model: Any, bodies: tuple[Body, ...], ids: NDArray[np.int_]) -> None:
        self._model = model
        place = {int(body): index for index, body in enumerate(ids)}
        drawn = []
        for geom in range(model.ngeom):
            body = int(model.geom_bodyid[geom])
            while body not in place and body:
                body = int(model.body_parentid[body])
            drawn.append(place.get(body, 0))
        self._body = np.array(drawn, dtype=np.int32)
        self._rank = np.array([_RANK[body.role] for body in bodies])

    def read(self, data: Any) -> tuple[NDArray[np.int32], Array, Array]:
        """Return bodies (K, 2), positions (K, 3) [m] and forces (K, 3) [N] on the first body, in world axes.

        Bodies that sleep are at rest in contacts that MuJoCo does not compute; they are missing.
        """
        contact = data.contact
        active = np.flatnonzero(contact.efc_address >= 0)
        local = np.zeros((active.size, 6))
        for row, index in zip(local, active, strict=True):
            mujoco.mj_contactForce(self._model, data, int(index), row)
        pressing = np.linalg.norm(local[:, :3], axis=1) >= SMALLEST
        active, local = active[pressing], local[pressing]
        # The rows of a contact's frame are its axes; the first, its normal, points from the first geom to the second,
        # and that is where the force pushes the second.
        axes = contact.frame[active].reshape(-1, 3, 3)
        force = -np.einsum("ki,kij->kj", local[:, :3], axes)
        bodies = self._body[contact.geom[active]].reshape(-1, 2)
        turned = self._rank[bodies[:, 0]] > self._rank[bodies[:, 1]]
        bodies[turned] = bodies[turned][:, ::-1]
        force[turned] *= -1.0
        return bodies, contact.pos[active].copy(), force


PERIOD = 1.0 / 30.0
"""Simulated time between two frames [s], that of a recording."""

Observer = Callable[[float, str, tuple[Body, ...], Array, Array], None]
"""Called with the time [s], the primitive's name, the B bodies that can be drawn, which are the same at every call,
their positions (B, 3) [m] and their quaternions (B, 4) wxyz, body to scene."""


class FrameFeed:
    """Hands the bodies' poses to an observer at 30 Hz of simulated time.

    Attributes:
        seconds: on the wall clock that the observer took so far.
    """

    def __init__(self, simulation: Simulation, on_frame: Observer) -> None:
        self._simulation, self._on_frame = simulation, on_frame
        self._bodies, self._ids = drawn_bodies(simulation.scene)
        self._next = 0.0
        self.seconds = 0.0

    def show(self, time: float, primitive: str, *, always: bool = False) -> None:
        """Show copies of the poses at `time` [s], if it is its turn or `always`."""
        if time < self._next - 1e-9 and not always:
            return
        self._next = PERIOD * math.floor(time / PERIOD + 1.0 + 1e-6)
        begun = perf_counter()
        self._on_frame(time, primitive, self._bodies, *self._simulation.poses(self._ids))
        self.seconds += perf_counter() - begun
