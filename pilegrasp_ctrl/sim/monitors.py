"""Monitors of a running simulation: a watchdog for invalid states, and a check for collisions with a crate."""

from __future__ import annotations

import math
import tempfile
from collections import deque
from collections.abc import Iterable
from pathlib import Path
from typing import Literal, get_args

import mujoco
import numpy as np
from numpy.typing import NDArray

from ..exceptions import SimulationError
from ..kernels.algebra import length_square
from ..planning.walls import RIM_HEIGHT, Wall
from ..types import Array
from .scene import Scene

Kind = Literal["object", "hand", "support"]
"""What a geom belongs to; the arm counts as support."""

KINDS: tuple[Kind, ...] = get_args(Kind)
"""The kinds, in the order of their numbers."""

MAX_DROP_PENETRATION = 0.012
"""Penetration above which a simulation is stopped while objects fall [m]; chosen. Two cylinders that are released over
the order's crate and meet at 3.1 m/s, when the lower one rebounds from the floor, overlap by 10 mm; limes by 4 mm."""

DROP_SPEED = 1.0
"""Speed of an object above which it falls [m/s]; chosen above the fastest push, 0.7 m/s. A fall of 51 mm reaches it."""

DROP_TIME = 0.1
"""Time for which a fall counts after an object was that fast [s]; chosen longer than its contact."""

MAX_PENETRATION: dict[tuple[Kind, Kind], float] = {
    ("object", "object"): 0.0063,
    ("object", "support"): 0.0056,
    ("hand", "object"): 0.0085,
    ("hand", "support"): 0.0081,
    ("hand", "hand"): 0.0082,
}
"""Penetration of each kind of pair above which a simulation is stopped [m]: 1.5 times the deepest of 207 valid pushes,
4.19, 3.70, 4.26, 4.04 and 4.10 mm (`docs/studies/overlap.py`, seeds 0 to 22). Those of a hand have another third, by
which its pads may be softer within their band."""

CHECK_INTERVAL = 0.01
"""Time between two checks of contacts [s], chosen; a collision lasts longer."""

MAX_STATES = 100
"""Number of states that the watchdog keeps [-], chosen: those of the last second."""


def kinds_of(model: mujoco.MjModel) -> NDArray[np.intp]:
    """Return the index into `KINDS` of each geom (ngeom,): objects are free, and the hand hangs on the wrist sensor."""
    root = np.full(model.nbody, KINDS.index("support"))
    for body in range(1, model.nbody):
        joint, parent = model.body_jntadr[body], model.body_parentid[body]
        if joint >= 0 and model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE:
            root[body] = KINDS.index("object")
        else:
            root[body] = KINDS.index("hand") if model.body(body).name == "sensor" else root[parent]
    return np.asarray(root[model.geom_bodyid], dtype=np.intp)


def _translations(model: mujoco.MjModel) -> NDArray[np.intp]:
    """Return the addresses of the objects' linear velocities in qvel."""
    free = model.jnt_dofadr[model.jnt_type == mujoco.mjtJoint.mjJNT_FREE]
    return np.asarray((free[:, None] + np.arange(3)).ravel(), dtype=np.intp)


class Watchdog:
    """Stops a simulation with an invalid state, and writes its last states to a file.

    Speeds and commands are checked after every control period, everything else every `CHECK_INTERVAL`.
    """

    def __init__(self, label: str) -> None:
        """Name the file of the last states after `label`."""
        self._label = label
        self._limits = np.full((len(KINDS), len(KINDS)), max(MAX_PENETRATION.values()))
        for (one, other), limit in MAX_PENETRATION.items():
            self._limits[KINDS.index(one), KINDS.index(other)] = limit
            self._limits[KINDS.index(other), KINDS.index(one)] = limit
        self._least_limit = float(self._limits.min())
        self._last_check, self._last_fall = 0.0, -math.inf
        self._states: deque[tuple[float, Array, Array, Array]] = deque(maxlen=MAX_STATES)
        self._data: mujoco.MjData | None = None

    def check(self, data: mujoco.MjData) -> None:
        """Check the state, and store it every `CHECK_INTERVAL`.

        Raises:
            SimulationError: The state is not finite, or a contact is deeper than `MAX_PENETRATION`, or than
                `MAX_DROP_PENETRATION` if neither body is the hand's and objects fall; the error names the file with the
                last states.
        """
        if data is not self._data:
            # Views, because the lookup of an array in MjData costs more than its reading.
            self._data, self._speeds, self._commands = data, data.qvel, data.ctrl
            self._kinds, self._falling = kinds_of(data.model), _translations(data.model)
        time = data.time
        # MuJoCo would replace a command that is not finite by zero and go on.
        finite = math.isfinite(length_square(self._speeds) + length_square(self._commands))
        if finite and time - self._last_check < CHECK_INTERVAL - 1e-9:
            return
        self._last_check = time
        finite = finite and bool(np.isfinite(data.qpos).all())
        self._states.append((data.time, data.qpos.copy(), data.qvel.copy(), data.ctrl.copy()))
        if not finite:
            self._stop(data, "the state is not finite; lower sim.timestep")
        if self._falling.size and float(np.abs(self._speeds[self._falling]).max()) > DROP_SPEED:
            self._last_fall = time
        if data.ncon and -float(data.contact.dist.min()) > self._least_limit:
            self._check_depths(data)

    def _check_depths(self, data: mujoco.MjData) -> None:
        depth, kinds = -data.contact.dist, self._kinds[data.contact.geom]
        limits = self._limits[kinds[:, 0], kinds[:, 1]]
        if data.time - self._last_fall < DROP_TIME:
            falls = (kinds != KINDS.index("hand")).all(axis=1)
            limits = np.where(falls, np.maximum(limits, MAX_DROP_PENETRATION), limits)
        worst = int((depth - limits).argmax())
        if depth[worst] > limits[worst]:
            names = " and ".join(data.model.geom(int(g)).name or f"geom {g}" for g in data.contact.geom[worst])
            self._stop(data, f"{names} overlap by {1e3 * depth[worst]:.1f} mm; lower strategy.speed or sim.timestep")

    def _stop(self, data: mujoco.MjData, reason: str) -> None:
        """Write the last states and raise the error."""
        raise SimulationError(f"at {data.time:.3f} s {reason}", self._write_states())

    def _write_states(self) -> Path | None:
        """Return a fresh file with the last states, whose name nobody can guess; None if it cannot be written."""
        times, qpos, qvel, ctrl = zip(*self._states, strict=True)
        try:
            number, name = tempfile.mkstemp(".npz", f"pilegrasp-last-states-{self._label}-")
        except OSError:
            return None
        file = Path(name)
        try:
            with open(number, "wb") as opened:
                np.savez_compressed(opened, time=times, qpos=qpos, qvel=qvel, ctrl=ctrl)
        except BaseException as error:
            file.unlink(missing_ok=True)
            if not isinstance(error, OSError):
                raise
            return None
        return file


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
