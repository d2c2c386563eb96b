"""Monitors of a running simulation: states that cannot be believed, and collisions with a crate."""

from __future__ import annotations

import math
import tempfile
from collections import deque
from collections.abc import Iterable
from pathlib import Path

import mujoco
import numpy as np

from ..exceptions import SimulationError
from ..planning.walls import Wall
from ..types import Array
from .scene import Scene

MAX_PENETRATION = 0.012
"""Penetration at which a contact is no contact any more [m]. The hardest that happens: two limes of a bag, let go
over the order's crate: they meet at 3.1 m/s as the lower one comes back from its floor, and overlap by 10 mm."""
INTERVAL = 0.01
"""Time between two looks [s]; a collision lasts longer."""
HISTORY = 100


class Watchdog:
    """Looks at speeds and commands after every control period; at everything else every 10 ms, which is soon enough."""

    def __init__(self, label: str) -> None:
        self._label = label
        self._looked = 0.0
        self._states: deque[tuple[float, Array, Array, Array]] = deque(maxlen=HISTORY)

    def check(self, data: mujoco.MjData) -> None:
        """Judge the state; note it every 10 ms.

        Raises:
            SimulationError: for a state that is not finite, or a contact deeper than `MAX_PENETRATION`; the sentence
                names the file with the last states.
        """
        v, command, time = data.qvel, data.ctrl, data.time
        # MuJoCo would replace a command that is not finite by zero and go on.
        finite = math.isfinite(v.dot(v) + command.dot(command))
        if finite and time - self._looked < INTERVAL - 1e-9:
            return
        self._looked = time
        finite = finite and bool(np.isfinite(data.qpos).all())
        self._states.append((data.time, data.qpos.copy(), data.qvel.copy(), data.ctrl.copy()))
        if not finite:
            self._stop(data, "the state is not finite; lower sim.timestep")
        if data.ncon:
            deepest = -float(data.contact.dist[: data.ncon].min())
            if deepest > MAX_PENETRATION:
                pair = data.contact.geom[int(data.contact.dist[: data.ncon].argmin())]
                names = " and ".join(data.model.geom(int(geom)).name or f"geom {geom}" for geom in pair)
                self._stop(data, f"{names} overlap by {1000 * deepest:.1f} mm; lower strategy.speed or sim.timestep")

    def _stop(self, data: mujoco.MjData, reason: str) -> None:
        file = Path(tempfile.gettempdir()) / f"pilegrasp-last-states-{self._label}.npz"
        times, qpos, qvel, ctrl = zip(*self._states, strict=True)
        try:
            np.savez_compressed(file, time=times, qpos=qpos, qvel=qvel, ctrl=ctrl)
            kept = f"the last {len(times)} states are in {file}"
        except OSError as error:
            kept = f"the last states could not be written to {file}: {error.strerror}"
        raise SimulationError(f"at {data.time:.3f} s {reason} ({kept})")


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
