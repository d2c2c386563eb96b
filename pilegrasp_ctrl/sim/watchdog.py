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

DEEPEST = 0.008
"""Penetration at which a contact is no contact any more: 30 % of a tennis ball's radius [m]."""
SATURATION_TIME = 1.0
"""A joint torque may sit at its limit for this long [s]."""
INTERVAL = 0.01
HISTORY = 100


class Watchdog:
    """Looks at the state after every control period; at contacts and torques every 10 ms, which is soon enough."""

    def __init__(self, torque_limit: Array, label: str) -> None:
        self._limit, self._label = torque_limit, label
        self._looked = 0.0
        self._saturated = np.zeros(len(torque_limit))
        self._states: deque[tuple[float, Array, Array, Array]] = deque(maxlen=HISTORY)

    def check(self, data: mujoco.MjData, torque: Array) -> None:
        """Judge the state; note it every 10 ms.

        Raises:
            SimulationError: for a state that is not finite, a contact deeper than `DEEPEST`, or a torque that has been
                at its limit for `SATURATION_TIME`; the sentence names the file with the last states.
        """
        finite = math.isfinite(data.qpos.sum() + data.qvel.sum() + torque.sum())
        elapsed = data.time - self._looked
        if finite and elapsed < INTERVAL - 1e-9:
            return
        self._looked = data.time
        self._states.append((data.time, data.qpos.copy(), data.qvel.copy(), data.ctrl.copy()))
        if not finite:
            self._stop(data, "the state is not finite; lower sim.timestep")
        if data.ncon:
            deepest = -float(data.contact.dist[: data.ncon].min())
            if deepest > DEEPEST:
                pair = data.contact.geom[int(data.contact.dist[: data.ncon].argmin())]
                names = " and ".join(data.model.geom(int(geom)).name or f"geom {geom}" for geom in pair)
                self._stop(data, f"{names} overlap by {1000 * deepest:.1f} mm; lower strategy.speed or sim.timestep")
        self._saturated = np.where(np.abs(torque) >= 0.999 * self._limit, self._saturated + elapsed, 0.0)
        if self._saturated.max() > SATURATION_TIME:
            joint = int(self._saturated.argmax())
            self._stop(
                data,
                f"joint {joint + 1} has been at its torque limit of {self._limit[joint]:.1f} N·m for "
                f"{SATURATION_TIME:.1f} s; lower strategy.grasp_force or strategy.speed",
            )

    def _stop(self, data: mujoco.MjData, reason: str) -> None:
        file = Path(tempfile.gettempdir()) / f"pilegrasp-last-states-{self._label}.npz"
        times, qpos, qvel, ctrl = zip(*self._states, strict=True)
        try:
            np.savez_compressed(file, time=times, qpos=qpos, qvel=qvel, ctrl=ctrl)
            kept = f"the last {len(times)} states are in {file}"
        except OSError as error:
            kept = f"the last states could not be written to {file}: {error.strerror}"
        raise SimulationError(f"at {data.time:.3f} s {reason} ({kept})")
