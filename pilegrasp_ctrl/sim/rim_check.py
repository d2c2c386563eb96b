"""Does the robot hit a crate? Looks at the simulated contacts, as whoever stands by would."""

from __future__ import annotations

from collections.abc import Iterable

import mujoco
import numpy as np

from ..planning.walls import Wall
from .scene import Scene

INTERVAL = 0.01
"""Between two looks [s]; a collision lasts longer."""
RIM = 0.02
"""Where a wall is no longer what a hand may slide along: its uppermost part [m]."""


class RimCheck:
    """Finds contacts of the robot with the walls of a crate that a push does not make.

    Fingers, thumb and palm push against a wall and slide along it; that is no collision unless they are at its rim.
    The sensor's housing and the arm's links have nothing to seek at a wall.
    """

    def __init__(self, scene: Scene, walls: Iterable[Wall]) -> None:
        model = scene.model
        self._model = model
        self._crates = {model.geom(wall.name).id: wall for wall in walls if wall.crate}
        self._hand = set(scene.hand_bodies) - {model.body("sensor").id}
        self._others = {0, *scene.objects}
        self._is_wall = np.zeros(model.ngeom, dtype=bool)
        self._is_wall[list(self._crates)] = True
        self._looked = -np.inf

    def collision(self, data: mujoco.MjData) -> str:
        """Return which part has hit which crate, or ""; looks every 10 ms."""
        if not self._crates or data.time - self._looked < INTERVAL - 1e-9:
            return ""
        self._looked = data.time
        pairs = data.contact.geom
        for index in np.flatnonzero(self._is_wall[pairs].any(axis=1)):
            first, second = pairs[index].tolist()
            wall, other = (first, second) if self._is_wall[first] else (second, first)
            body = int(self._model.geom_bodyid[other])
            if body in self._others:
                continue
            hit = self._crates[wall]
            height = data.contact.pos[index, 2]
            if body not in self._hand or height > hit.center[2] + hit.half_size[2] - RIM:
                return f"collision with the {hit.crate}'s rim: {self._model.body(body).name} at {hit.name}"
        return ""
