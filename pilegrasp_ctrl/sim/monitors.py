"""Monitors of a running simulation: a watchdog for invalid states, and a check for collisions with a crate."""

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
"""Penetration above which the simulation is stopped [m]; chosen. The deepest valid contact has 10 mm: two limes of a
bag that is released over the order's crate meet at 3.1 m/s when the lower one rebounds from the floor."""

CHECK_INTERVAL = 0.01
"""Time between two checks of contacts [s], chosen; a collision lasts longer."""

MAX_STATES = 100
"""Number of states that the watchdog keeps [-], chosen: those of the last second."""

RIM_HEIGHT = 0.02
"""Height of a crate's rim, the uppermost part of its walls, which no hand may touch [m]; chosen."""


class Watchdog:
    """Stops a simulation with an invalid state, and writes its last states to a file.

    Speeds and commands are checked after every control period, everything else every `CHECK_INTERVAL`.
    """

    def __init__(self, label: str) -> None:
        """Name the file of the last states after `label`."""
        self._label = label
        self._last_check = 0.0
        self._states: deque[tuple[float, Array, Array, Array]] = deque(maxlen=MAX_STATES)

    def check(self, data: mujoco.MjData) -> None:
        """Check the state, and store it every `CHECK_INTERVAL`.

        Raises:
            SimulationError: The state is not finite, or a contact is deeper than `MAX_PENETRATION`; the error names the
                file with the last states.
        """
        v, command, time = data.qvel, data.ctrl, data.time
        # MuJoCo would replace a command that is not finite by zero and go on.
        finite = math.isfinite(v.dot(v) + command.dot(command))
        if finite and time - self._last_check < CHECK_INTERVAL - 1e-9:
            return
        self._last_check = time
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
        """Write the last states and raise the error."""
        file = Path(tempfile.gettempdir()) / f"pilegrasp-last-states-{self._label}.npz"
        times, qpos, qvel, ctrl = zip(*self._states, strict=True)
        try:
            np.savez_compressed(file, time=times, qpos=qpos, qvel=qvel, ctrl=ctrl)
            kept = f"the last {len(times)} states are in {file}"
        except OSError as error:
            kept = f"the last states could not be written to {file}: {error.strerror}"
        raise SimulationError(f"at {data.time:.3f} s {reason} ({kept})")


class RimCheck:
    """Finds collisions of the robot with the walls of a crate.

    Fingers, thumb and palm may push against a wall and slide along it, except at its rim. The sensor's housing and the
    arm's links must not touch a wall at all.
    """

    def __init__(self, scene: Scene, walls: Iterable[Wall]) -> None:
        """Check the walls that belong to a crate."""
        model = scene.model
        self._model = model
        self._walls = {model.geom(wall.name).id: wall for wall in walls if wall.crate}
        self._hand = set(scene.hand_bodies) - {model.body("sensor").id}
        self._others = {0, *scene.objects}
        self._is_wall = np.zeros(model.ngeom, dtype=bool)
        self._is_wall[list(self._walls)] = True
        self._last_check = -np.inf

    def find_collision(self, data: mujoco.MjData) -> str | None:
        """Return a text with part and crate of a collision, or None. Contacts are checked every `CHECK_INTERVAL`."""
        if not self._walls or data.time - self._last_check < CHECK_INTERVAL - 1e-9:
            return None
        self._last_check = data.time
        pairs = data.contact.geom
        for index in np.flatnonzero(self._is_wall[pairs].any(axis=1)):
            first, second = pairs[index].tolist()
            geom, other = (first, second) if self._is_wall[first] else (second, first)
            body = int(self._model.geom_bodyid[other])
            if body in self._others:
                continue
            wall = self._walls[geom]
            height = data.contact.pos[index, 2]
            if body not in self._hand or height > wall.center[2] + wall.half_size[2] - RIM_HEIGHT:
                return f"collision with the {wall.crate}'s rim: {self._model.body(body).name} at {wall.name}"
        return None
