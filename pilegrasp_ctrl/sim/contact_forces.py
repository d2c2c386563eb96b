"""What touches what in a simulation, and with how much force."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from ..recording import Body
from ..types import Array

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
