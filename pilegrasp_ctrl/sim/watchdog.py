"""Stops a simulation that can no longer be believed, and keeps its last states for whoever looks into it."""

from __future__ import annotations

import math
import tempfile
from collections import deque
from pathlib import Path

import mujoco
import numpy as np

from ..exceptions import SimulationError
from ..types import Array

MAX_PENETRATION = 0.012
"""Penetration at which a contact is no contact any more [m]. The hardest that happens: two limes of a bag, let go
over the order's crate: they meet at 3.1 m/s as the lower one comes back from its floor, and overlap by 10 mm."""
INTERVAL = 0.01
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
