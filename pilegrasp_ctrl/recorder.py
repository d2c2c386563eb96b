"""Sampling of the closed loop: bodies, contacts and signals become a recording."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arm.state import ArmState
from .primitives.primitive import Setpoint
from .programs.attempt import Attempt
from .recording import Recording
from .recording_parts import Contacts
from .sim.readout import FRAME_PERIOD, ContactForces, drawn_bodies, next_multiple
from .types import Array, Observation

SIGNAL_PERIOD = 0.01
"""Simulated time between two samples of the signals [s]; chosen."""

UNITS = {
    "push_force": "N",
    "normal_force": "N",
    "wrench": "N, N·m",
    "sensor_saturated": "1",
    "torque_ratio": "1",
    "tracking_error": "m",
    "orientation_error": "rad",
    "closure": "1",
    "q": "rad",
    "v": "rad/s",
    "tool_position": "m",
    "reference_position": "m",
}
"""Names of a recording's signals, and their units."""


class Recorder:
    """Samples bodies and contacts at 30 Hz and signals at 100 Hz.

    No wall-clock time is recorded, so equal attempts give equal bytes. Positions are in the scene's frame. Wrenches and
    forces are along the axes that the arm takes for the world's.

    Attributes:
        push_direction: (3,) unit vector along which the force of the push is recorded.
    """

    def __init__(self, attempt: Attempt) -> None:
        self._simulation, self._torque_limit = attempt.simulation, attempt.arm.torque_limit
        self._to_scene = attempt.transform_known_to_scene
        self.push_direction = attempt.plan.direction
        scene = self._simulation.scene
        self._bodies, self._ids = drawn_bodies(scene)
        self._contact_forces = ContactForces(scene.model, self._bodies, self._ids)
        self._frames: list[tuple[float, Array, Array]] = []
        self._contacts: list[tuple[NDArray[np.int32], Array, Array]] = []
        self._rows: list[dict[str, Any]] = []
        self._next_frame = self._next_row = 0.0

    def sample(
        self,
        observation: Observation,
        state: ArmState,
        setpoint: Setpoint,
        torque: Array,
        zero: Array,
        *,
        always: bool = False,
    ) -> None:
        """Record a control tick if a sample is due, or `always`; forces are relative to the wrench `zero` (6,)."""
        if observation.time >= self._next_frame - 1e-9:
            self._next_frame = next_multiple(observation.time, FRAME_PERIOD)
            self._frames.append((observation.time, *self._simulation.poses(self._ids)))
            self._contacts.append(self._contact_forces.read(self._simulation.data))
        due = observation.time >= self._next_row - 1e-9
        if not due and (not always or self._rows[-1]["time"] >= observation.time):
            return
        self._next_row = next_multiple(observation.time, SIGNAL_PERIOD)
        reference = setpoint.reference.pose
        relative = observation.wrench[:3] - zero[:3]
        turn = reference.rotation @ state.pose.rotation.T
        self._rows.append(
            {
                "time": observation.time,
                "push_force": -self.push_direction @ relative,
                "normal_force": relative[2],
                "wrench": observation.wrench,
                "sensor_saturated": float(bool(observation.saturated)),
                "torque_ratio": np.abs(torque) / self._torque_limit,
                "tracking_error": np.linalg.norm(reference.translation - state.pose.translation),
                "orientation_error": np.arccos(np.clip(0.5 * (np.trace(turn) - 1.0), -1.0, 1.0)),
                "closure": setpoint.closure,
                "q": observation.q,
                "v": observation.v,
                "tool_position": self._in_scene(state.pose.translation),
                "reference_position": self._in_scene(reference.translation),
            }
        )

    def _in_scene(self, point: Array) -> Array:
        return self._to_scene.translation + self._to_scene.rotation @ point

    def finish(self, meta: dict[str, Any]) -> Recording:
        """Return the recording."""
        time, position, quaternion = zip(*self._frames, strict=True)
        rows = self._rows
        pairs, points, forces = (np.concatenate(parts) for parts in zip(*self._contacts, strict=True))
        return Recording(
            meta=meta | {"signal_units": UNITS},
            bodies=self._bodies,
            frame_time=np.array(time),
            body_position=np.array(position),
            body_quaternion=np.array(quaternion),
            signal_time=np.array([row["time"] for row in rows]),
            signals={name: np.array([row[name] for row in rows]) for name in UNITS},
            contacts=Contacts(
                np.cumsum([0, *(len(found[0]) for found in self._contacts)]),
                bodies=pairs,
                position=points,
                force=forces,
            ),
        )
