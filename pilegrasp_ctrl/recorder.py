"""Sampling of the closed loop: bodies, contacts and signals become a recording, or frames for an observer."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import hand_folder
from .analysis.carried import carried, count_carried, releases_in
from .arm.state import ArmState
from .primitives.primitive import Setpoint
from .programs.attempt import Attempt
from .programs.body_union import BodyUnion
from .programs.result import EpisodeResult
from .provenance import versions
from .recording import Recording
from .recording_parts import Body, Contacts
from .sim.backend import SceneView
from .types import Array, Observation, Outcome
from .vectors import inner, rotated

FRAME_PERIOD = 1.0 / 30.0
"""Simulated time between two frames [s], in a recording and for an observer; chosen."""

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

Observer = Callable[[float, str, tuple[Body, ...], Array, Array], None]
"""Function that is called with the time [s], the primitive's name and the B drawn bodies, which are the same in every
call. Further arguments are their positions (B, 3) [m] and quaternions (B, 4) wxyz, body to scene."""

SampleObserver = Callable[[Mapping[str, Any]], None]
"""Function that is called with a sample: `time` [s], and the value of each signal of `UNITS`."""


class Signals:
    """Makes samples of the signals.

    Positions are in the scene's frame. Wrenches and forces are along the axes that the arm takes for the world's.

    Attributes:
        push_direction: (3,) unit vector along which the force of the push is measured.
    """

    def __init__(self, attempt: Attempt) -> None:
        self.exchange(attempt)
        self.push_direction = attempt.plan.direction

    def exchange(self, attempt: Attempt) -> None:
        """Go on with another arm."""
        self._to_scene, self._torque_limit = attempt.transform_known_to_scene, attempt.arm.torque_limit

    def sample(
        self, observation: Observation, state: ArmState, setpoint: Setpoint, torque: Array, zero: Array
    ) -> dict[str, Any]:
        """Return the values of a control tick by name; forces are relative to the wrench `zero` (6,)."""
        reference = setpoint.reference.pose
        relative = observation.wrench[:3] - zero[:3]
        actual = state.pose
        # The trace of the turn between two rotations.
        trace = inner(reference.rotation.ravel(), actual.rotation.ravel())
        return {
            "time": observation.time,
            "push_force": -inner(self.push_direction, relative),
            "normal_force": relative[2],
            "wrench": observation.wrench,
            "sensor_saturated": float(bool(observation.saturated)),
            "torque_ratio": np.abs(torque) / self._torque_limit,
            "tracking_error": math.dist(reference.translation, actual.translation),
            "orientation_error": math.acos(min(max(0.5 * (trace - 1.0), -1.0), 1.0)),
            "closure": setpoint.closure,
            "q": observation.q,
            "v": observation.v,
            "tool_position": self._in_scene(actual.translation),
            "reference_position": self._in_scene(reference.translation),
        }

    def _in_scene(self, point: Array) -> Array:
        return self._to_scene.translation + rotated(self._to_scene.rotation, point)


class Recorder:
    """Samples bodies and contacts at 30 Hz and signals at 100 Hz.

    No wall-clock time is recorded, so equal attempts give equal bytes.

    Attributes:
        signals: Signals that are sampled.
    """

    def __init__(self, attempt: Attempt, view: SceneView) -> None:
        self._attempt, self._view = attempt, view
        self.signals = Signals(attempt)
        self._bodies = BodyUnion(view.bodies)
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
            self._frames.append((observation.time, *self._bodies.place(*self._view.poses())))
            pairs, points, forces = self._view.contacts()
            self._contacts.append((self._bodies.indices[np.asarray(pairs, dtype=np.int32)], points, forces))
        due = observation.time >= self._next_row - 1e-9
        if not due and (not always or self._rows[-1]["time"] >= observation.time):
            return
        self._next_row = next_multiple(observation.time, SIGNAL_PERIOD)
        self._rows.append(self.signals.sample(observation, state, setpoint, torque, zero))

    def exchange(self, attempt: Attempt, view: SceneView) -> None:
        """Go on with another arm, hand and view of the same objects."""
        self._attempt, self._view = attempt, view
        self.signals.exchange(attempt)
        self._bodies = self._bodies.joined(view.bodies)

    def finish(self, result: EpisodeResult) -> Recording:
        """Return the recording of an attempt with this result."""
        time = [frame[0] for frame in self._frames]
        position, quaternion = zip(*(self._bodies.completed(*frame[1:]) for frame in self._frames), strict=True)
        rows = self._rows
        pairs, points, forces = (np.concatenate(parts) for parts in zip(*self._contacts, strict=True))
        return Recording(
            meta=_meta(self._attempt, result) | {"signal_units": UNITS},
            bodies=self._bodies.bodies,
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


def _meta(attempt: Attempt, result: EpisodeResult) -> dict[str, Any]:
    """Return the `meta` of the recording."""
    scenario = attempt.scenario
    return {
        "scenario": scenario.name,
        "summary": scenario.summary,
        "seed": attempt.seed,
        "config_hash": result.config_hash,
        "config": scenario.model_dump(mode="json"),
        "hand": hand_folder.label(scenario.hand),
        "grasp_force": scenario.strategy.grasp_force if attempt.grasp_force is None else attempt.grasp_force,
        "success": result.success,
        "grasped": result.grasped,
        "reason": result.reason,
        "outcomes": [outcome.as_dict() for outcome in result.outcomes],
        "packing_density": result.packing_density,
        "attempts": [pick.as_dict() for pick in result.attempts],
        "versions": versions(),
    }


class FrameFeed:
    """Passes the poses of the drawn bodies to an observer every `FRAME_PERIOD`.

    Attributes:
        seconds: Wall-clock time that the observer has taken so far [s].
    """

    def __init__(self, view: SceneView, on_frame: Observer) -> None:
        self._view, self._on_frame = view, on_frame
        self._next = 0.0
        self.seconds = 0.0

    def show(self, time: float, primitive: str, *, always: bool = False) -> None:
        """Pass the poses at `time` [s] to the observer if a frame is due, or `always`."""
        if time < self._next - 1e-9 and not always:
            return
        self._next = next_multiple(time, FRAME_PERIOD)
        begun = perf_counter()
        self._on_frame(time, primitive, self._view.bodies, *self._view.poses())
        self.seconds += perf_counter() - begun


class SampleFeed:
    """Passes the signals to an observer every `SIGNAL_PERIOD`, recorded or not.

    Attributes:
        signals: Signals that are sampled.
        seconds: Wall-clock time that the observer has taken so far [s].
    """

    def __init__(self, attempt: Attempt, on_sample: SampleObserver) -> None:
        self.signals, self._on_sample = Signals(attempt), on_sample
        self._next = 0.0
        self.seconds = 0.0

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
        """Pass the signals of a control tick to the observer if a sample is due, or `always`."""
        if observation.time < self._next - 1e-9 and not always:
            return
        self._next = next_multiple(observation.time, SIGNAL_PERIOD)
        begun = perf_counter()
        self._on_sample(self.signals.sample(observation, state, setpoint, torque, zero))
        self.seconds += perf_counter() - begun

    def exchange(self, attempt: Attempt, view: SceneView) -> None:
        """Go on with another arm."""
        self.signals.exchange(attempt)


class HandWatch:
    """Samples tool and objects every `FRAME_PERIOD`, recorded or not, and tells what the hand carried."""

    def __init__(self) -> None:
        self._rows: list[tuple[float, Array, Array]] = []
        self._next = 0.0

    def is_due(self, time: float) -> bool:
        """Return whether a sample is due at `time` [s]."""
        return time >= self._next - 1e-9

    def sample(self, time: float, tool: Array, objects: Array) -> None:
        """Keep the positions of the tool (3,) and of the objects (n, 3) in the scene at `time` [s], all in metres."""
        self._next = next_multiple(time, FRAME_PERIOD)
        self._rows.append((time, tool, objects))

    def count(self, outcomes: Sequence[Outcome], starts: Sequence[float]) -> dict[str, Any]:
        """Return JSON values of what the hand carried, as `count_carried` does.

        Args:
            outcomes: Outcomes of all primitives.
            starts: Times at which the attempts of an order began [s]; none for a single attempt.
        """
        if not self._rows:
            return count_carried(())
        time, tool, objects = (np.array(column) for column in zip(*self._rows, strict=True))
        names = [f"object_{index}" for index in range(objects.shape[1])]
        releases = releases_in([outcome.as_dict() for outcome in outcomes])
        return count_carried(carried(time, tool, objects, names, starts, releases))


def next_multiple(time: float, period: float) -> float:
    """Return the next multiple of `period` that is later than `time` by more than rounding [s]."""
    return period * math.floor(time / period + 1.0 + 1e-6)
