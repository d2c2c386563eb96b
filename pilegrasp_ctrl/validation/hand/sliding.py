"""Sliding of a hand on the table in an attempt, read from its recording."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ...exceptions import RecordingError
from ...recording import Recording
from ...recording_parts import Shape
from ...sim.hand import Hand
from ...types import Array

FINGERS = ("pinky", "ring", "middle", "index")
"""Fingers of the RBO Hand 2 without the thumb."""

START_TIME = 0.3
"""Time from the start of the push until the hand has reached its speed and its depth [s]; chosen."""

PILE_FORCE = 4.0
"""Force along the push below which the hand has not met the pile yet [N]; chosen, the friction of a skin of 0.8 on a
table that presses with 5 N."""


@dataclass(frozen=True, slots=True)
class HandSlide:
    """The RBO Hand 2 between the start of the push and F_grasp.

    Attributes:
        palm_clearance: Least height of the palm's boxes above the table [m].
        sensor_clearance: Least height of the sensor's housing above the table [m].
        alone: Mean bend of the fingers before they meet the pile [rad]; positive in the closing direction.
        at_trigger: Mean bend of the fingers when the push ends [rad].
        tip_slope: Slope of the fingers' last segments against the table before they meet the pile [rad].
        table_force: Force of the table on the hand before it meets the pile [N].
    """

    palm_clearance: float
    sensor_clearance: float
    alone: float
    at_trigger: float
    tip_slope: float
    table_force: float


@dataclass(frozen=True, slots=True, eq=False)
class HandCourse:
    """The RBO Hand 2 in the push, frame by frame.

    Attributes:
        time: (F,) Time since the push began [s].
        palm_height: (F,) Height of the palm's lowest corner above the table [m].
        bend: (F,) Mean bend of the fingers [rad].
    """

    time: Array
    palm_height: Array
    bend: Array


@dataclass(frozen=True, slots=True)
class ShovelSlide:
    """The shovel between the start of the push and the end of the scoop.

    Attributes:
        edge_height: Largest height of the leading edge above the table in the push [m].
        heel_clearance: Least height of the floor's rear end above the table in the push [m].
        table_force: Mean force of the table on the shovel before it meets the pile [N].
        peak_table_force: Largest force of the table there [N].
        slope: Slope of the floor against the table in the push [rad].
        scoop_angle: Angle by which the floor has tilted back when the scoop ends [rad].
    """

    edge_height: float
    heel_clearance: float
    table_force: float
    peak_table_force: float
    slope: float
    scoop_angle: float


def hand_slide(recording: Recording, hand: Hand) -> HandSlide:
    """Return the clearances, bends and force of the sliding soft hand.

    Raises:
        RecordingError: The recorded attempt has no push.
    """
    frames = _frames(recording)
    alone, pushing = _windows(recording, frames.time)
    bend, slope = zip(*(_finger(frames, hand, finger) for finger in FINGERS), strict=True)
    mean_bend, mean_slope = np.mean(bend, axis=0), np.mean(slope, axis=0)
    return HandSlide(
        palm_clearance=float(frames.lowest("palm")[pushing].min()),
        sensor_clearance=float(frames.lowest("sensor")[pushing].min()),
        alone=float(mean_bend[alone].mean()),
        at_trigger=float(mean_bend[pushing][-1]),
        tip_slope=float(mean_slope[alone].mean()),
        table_force=float(_table_force(recording).mean()),
    )


def hand_course(recording: Recording, hand: Hand) -> HandCourse:
    """Return the push of the soft hand as curves."""
    frames, push = _frames(recording), _outcome(recording, "push")
    shown = (frames.time >= push["start"]) & (frames.time <= push["end"])
    bend = np.mean([_finger(frames, hand, finger)[0] for finger in FINGERS], axis=0)
    return HandCourse(frames.time[shown] - push["start"], frames.lowest("palm")[shown], bend[shown])


def shovel_slide(recording: Recording, hand: Hand) -> ShovelSlide:
    """Return the heights, forces and angles of the sliding and scooping shovel.

    Raises:
        RecordingError: The recorded attempt has no push.
    """
    frames = _frames(recording)
    _, pushing = _windows(recording, frames.time)
    tool, flange = hand.transform_tool_to_flange, frames.rotation("sensor")
    edge = frames.position("sensor") + flange.apply(tool.translation.copy())
    along = flange.apply(tool.rotation[:, 0].copy())
    slope = np.arcsin(-along[:, 2])
    heel = edge - hand.parameters["scoop"]["length"] * along
    force = _table_force(recording)
    scooped = int(np.searchsorted(frames.time, _outcome(recording, "grasp")["end"])) - 1
    return ShovelSlide(
        edge_height=float(edge[pushing, 2].max()),
        heel_clearance=float(heel[pushing, 2].min()),
        table_force=float(force.mean()),
        peak_table_force=float(force.max()),
        slope=float(slope[pushing].mean()),
        scoop_angle=float(slope[pushing][-1] - slope[scooped]),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Frames:
    """Body poses of a recording by body name."""

    recording: Recording
    time: Array
    index: dict[str, int]

    def position(self, body: str) -> Array:
        return self.recording.body_position[:, self.index[body]].astype(float)

    def rotation(self, body: str) -> Rotation:
        return Rotation.from_quat(self.recording.body_quaternion[:, self.index[body]], scalar_first=True)

    def lowest(self, body: str) -> Array:
        """Return the height (F,) of the lowest point of a body's shapes [m]."""
        shapes = self.recording.bodies[self.index[body]].shapes
        position, rotation = self.position(body), self.rotation(body)
        heights = [position[:, 2] + rotation.apply(corner)[:, 2] for shape in shapes for corner in _corners(shape)]
        return np.min(heights, axis=0)


def _frames(recording: Recording) -> _Frames:
    return _Frames(recording, recording.frame_time, {body.name: i for i, body in enumerate(recording.bodies)})


def _corners(shape: Shape) -> Array:
    """Return the corners (8, 3) of the box around a shape, in the body's axes."""
    signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
    turn = Rotation.from_quat(shape.quaternion, scalar_first=True)
    corners: Array = np.array(shape.position) + turn.apply(signs * shape.half_extents())
    return corners


def _finger(frames: _Frames, hand: Hand, finger: str) -> tuple[Array, Array]:
    """Return the bend (F,) between a finger's last segment and the straight finger, and the segment's slope (F,)."""
    parameters = hand.parameters["fingers"]
    straight = np.subtract(parameters["tip"][finger], parameters["base"][finger])
    straight /= np.linalg.norm(straight)
    normal = hand.transform_tool_to_flange.rotation[:, 2]
    normal = normal - (normal @ straight) * straight
    along = frames.rotation(f"{finger}_{parameters['segments']}").apply([1.0, 0.0, 0.0])
    local = frames.rotation("sensor").inv().apply(along)
    bend = np.arctan2(local @ normal / np.linalg.norm(normal), local @ straight)
    return bend, np.arcsin(-along[:, 2])


def _windows(recording: Recording, time: Array) -> tuple[NDArray[np.bool], NDArray[np.bool]]:
    """Return masks of the times that belong to the sliding before the pile is met, and to the whole push."""
    push = _outcome(recording, "push")
    pushing = (time >= push["start"] + START_TIME) & (time <= push["end"])
    felt = np.interp(time, recording.signal_time, recording.signals["push_force"])
    met = np.flatnonzero(pushing & (felt > PILE_FORCE))
    alone = pushing & (time < (time[met[0]] if len(met) else np.inf))
    if not alone.any():
        raise RecordingError(
            "the recording shows no sliding before the pile; record an attempt whose push starts in front of the pile"
        )
    return alone, pushing


def _table_force(recording: Recording) -> Array:
    """Return the table's force on the hand while it slides alone [N], from the wrist sensor; it is zero in the air."""
    alone, _ = _windows(recording, recording.signal_time)
    vertical = recording.signals["wrench"][:, 2].astype(float)
    approach = _outcome(recording, "approach")
    start = int(np.searchsorted(recording.signal_time, approach["start"]))
    return np.asarray(vertical[alone] - vertical[start])


def _outcome(recording: Recording, name: str) -> dict[str, float]:
    for outcome in recording.meta["outcomes"]:
        if outcome["name"] == name:
            return dict(outcome)
    raise RecordingError(f"the recording is of an attempt without a {name}; record one that reaches its {name}")
