"""What the objects did during the push, seen from the hand."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..recording import Recording
from .hand_mouth import HandMouth
from .meta import lookup, number
from .slanted_wall import nearer_side

Array = NDArray[np.float64]

POSITIONS = ("tool_position", "reference_position")
"""Signals without which nothing can be said."""

MOVING = 0.1
"""The pile moves as soon as one object is faster than this share of the hand's speed."""

STANDING = 1e-5
"""The reference has arrived where it is nearer than this to its last position [m]; at |v_hand| that is 0.1 ms."""

SHORTEST_PUSH = 0.005
"""A push that asked for less than this has no direction [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class PushMotion:
    """F frames of n objects, from the first motion of the pile to the end of the push; nothing later.

    A push that never reaches F_grasp waits at the end of its way; that time is left out, as a hand that stands does not
    push.

    The hand's frame has x where its fingers point, level, which is along the push but for beta; y to the left, z up.
    Relative positions are counted from the middle of the hand's leading edge, so that an object with x < 0 has the hand
    beneath it.

    Attributes:
        time: (F,) [s].
        hand: (F, 2) the leading edge's middle in the scene, along the axes of the hand's frame [m].
        relative: (F, n, 2) objects' centres in the hand's frame [m].
        objects: (n,) their names.
        radius: of a ball; of another object, the geometric mean of its half-extents [m].
        half_width: half the width of the leading edge [m].
        length: from the leading edge to the rear of the hand [m].
        axes: (2, 3) unit vectors of x and y in the scene.
        triggered: whether the force along the push reached F_grasp.
        rigid: whether the hand is a single body, which cannot close.
        nearer_side: on which side a slanted wall is nearer, see `slanted_wall`.
    """

    time: Array
    hand: Array
    relative: Array
    objects: tuple[str, ...]
    radius: float
    half_width: float
    length: float
    axes: Array
    triggered: bool
    rigid: bool
    nearer_side: int

    @classmethod
    def of(cls, recording: Recording) -> PushMotion | None:
        """Return None where there was no push, nothing to push, or a pile that never moved."""
        push = primitive(recording, "push")
        chosen = [index for index, body in enumerate(recording.bodies) if body.role == "object" and body.shapes]
        if push is None or not chosen or not all(map(partial(has_points, recording), POSITIONS)):
            return None
        along = _axes(recording, push)
        if along is None:
            return None
        axes = _turned(along, math.radians(strategy_number(recording, "beta_deg", 0.0)))
        first = int(np.searchsorted(recording.frame_time, push["start"] - 1e-9))
        last = int(np.searchsorted(recording.frame_time, _end(recording, push, along) + 1e-9))
        if last - first < 2:
            return None
        first = _first_motion(recording, chosen, slice(first, last), along)
        if last - first < 2:
            return None
        frames = slice(first, last)
        tool = tool_position(recording, recording.frame_time[frames])
        radius = float(np.median([_radius(recording.bodies[index].shapes[0]) for index in chosen]))
        mouth = HandMouth.of(recording, frames, tool, axes, depth=radius)
        if mouth is None or (tool[-1] - tool[0]) @ along[0] <= 0.0:
            return None
        middle = np.array([mouth.front, 0.5 * (mouth.left + mouth.right)])
        hand = tool @ axes.T + middle
        return cls(
            time=recording.frame_time[frames],
            hand=hand,
            relative=recording.body_position[frames, chosen].astype(float) @ axes.T - hand[:, None],
            objects=tuple(recording.bodies[index].name for index in chosen),
            radius=radius,
            half_width=0.5 * mouth.width,
            length=mouth.front - mouth.rear,
            axes=axes,
            triggered=push.get("trigger") == "grasp force",
            rigid=sum(body.role == "hand" for body in recording.bodies) == 1,
            nearer_side=nearer_side(recording, axes),
        )

    @property
    def hand_speed(self) -> float:
        """Median speed of the hand along its way [m/s]: that of its slide, also where a wall stops it at the end."""
        return float(np.median(np.linalg.norm(self.hand_velocity, axis=1)))

    @property
    def hand_velocity(self) -> Array:
        """(F-1, 2) velocities of the hand in the scene, along the axes of its frame [m/s]."""
        return np.diff(self.hand, axis=0) / np.diff(self.time)[:, None]

    @property
    def relative_velocity(self) -> Array:
        """(F-1, n, 2) velocities relative to the hand, in the mean between two frames [m/s]."""
        return np.diff(self.relative, axis=0) / np.diff(self.time)[:, None, None]

    @property
    def absolute_velocity(self) -> Array:
        """(F-1, n, 2) velocities in the scene, along the axes of the hand's frame [m/s]."""
        return self.relative_velocity + self.hand_velocity[:, None]

    @property
    def midpoints(self) -> Array:
        """(F-1, n, 2) relative positions half-way between two frames [m], where those velocities belong."""
        return 0.5 * (self.relative[1:] + self.relative[:-1])

    @property
    def before_mouth(self) -> NDArray[np.bool_]:
        """(F-1, n) whether an object is before the leading edge, in its width and at most two diameters away."""
        x, y = np.moveaxis(self.midpoints, -1, 0)
        return (x > 0.0) & (x <= 4.0 * self.radius) & (np.abs(y) <= self.half_width)

    @property
    def beside_mouth(self) -> NDArray[np.bool_]:
        """(F-1, n) whether an object is ahead of the leading edge, beyond its ends."""
        x, y = np.moveaxis(self.midpoints, -1, 0)
        return (x > 0.0) & (np.abs(y) > self.half_width)

    @property
    def in_hand(self) -> NDArray[np.bool_]:
        """(F, n) whether an object's centre is behind the leading edge and within its width: the hand is beneath it."""
        x, y = np.moveaxis(self.relative, -1, 0)
        return (x < 0.0) & (x > -self.length) & (np.abs(y) <= self.half_width)

    @property
    def at_edge(self) -> NDArray[np.bool_]:
        """(F, n) whether an object's centre is at most a radius before the leading edge, within its width."""
        x, y = np.moveaxis(self.relative, -1, 0)
        return (x >= 0.0) & (x <= self.radius) & (np.abs(y) <= self.half_width)


def primitive(recording: Recording, name: str) -> Mapping[str, Any] | None:
    """Return the outcome of a primitive that has a start and an end, or None."""
    outcomes = recording.meta.get("outcomes")
    for row in outcomes if isinstance(outcomes, list) else []:
        if isinstance(row, Mapping) and row.get("name") == name:
            times = (row.get("start"), row.get("end"))
            return row if all(isinstance(time, int | float) and math.isfinite(time) for time in times) else None
    return None


def has_points(recording: Recording, name: str) -> bool:
    """Return whether a signal of points in space was recorded."""
    signal = recording.signals.get(name)
    return signal is not None and signal.ndim == 2 and signal.shape[0] > 0 and signal.shape[1] == 3


def tool_position(recording: Recording, times: Array) -> Array:
    """Return the tool's positions (F, 3) [m] at some times."""
    signal = recording.signals["tool_position"]
    return np.stack([np.interp(times, recording.signal_time, signal[:, axis]) for axis in range(3)], axis=1)


def strategy_number(recording: Recording, name: str, usual: float) -> float:
    """Return a number that the recorded configuration gives the strategy; `usual` where it gives none."""
    noted = number(lookup(recording.meta, f"config.strategy.{name}"))
    return usual if noted is None else noted


def _turned(axes: Array, angle: float) -> Array:
    """Return level axes (2, 3) turned to the left."""
    x, y = axes
    return np.array([math.cos(angle) * x + math.sin(angle) * y, math.cos(angle) * y - math.sin(angle) * x])


def _axes(recording: Recording, push: Mapping[str, Any]) -> Array | None:
    """Return (2, 3) unit vectors along the push and to its left, from the reference, which no contact deflects."""
    reference = recording.signals["reference_position"]
    ends = [np.interp((push["start"], push["end"]), recording.signal_time, reference[:, axis]) for axis in range(2)]
    x, y = (end - start for start, end in ends)
    length = math.hypot(x, y)
    if length < SHORTEST_PUSH:
        return None
    return np.array([[x, y, 0.0], [-y, x, 0.0]]) / length


def _end(recording: Recording, push: Mapping[str, Any], axes: Array) -> float:
    """Return when the push ended, or when its reference had come to its end and stood [s]."""
    during = (recording.signal_time >= push["start"] - 1e-9) & (recording.signal_time <= push["end"] + 1e-9)
    time = recording.signal_time[during]
    if not time.size:
        return float(push["end"])
    left = recording.signals["reference_position"][during] @ axes[0]
    standing = left[-1] - left < STANDING
    return float(min(push["end"], time[np.argmax(standing)])) if standing.any() else float(push["end"])


def _first_motion(recording: Recording, chosen: list[int], frames: slice, axes: Array) -> int:
    """Return the frame after which the first object moves; the end of the push where none does."""
    time = recording.frame_time[frames]
    hand = tool_position(recording, time) @ axes[0]
    step = np.diff(recording.body_position[frames, chosen].astype(float), axis=0)
    speed = np.linalg.norm(step, axis=2).max(axis=1) / np.diff(time)
    moving = speed > MOVING * (hand[-1] - hand[0]) / (time[-1] - time[0])
    return frames.start + int(np.argmax(moving)) if moving.any() else frames.stop


def _radius(shape: Any) -> float:
    return float(np.prod(shape.half_extents()) ** (1.0 / 3.0))
