"""The motion of the objects during the push, relative to the hand."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..recording import Recording
from ..recording_parts import Shape
from ..types import Array
from ..vectors import components, inner, rotated
from .hand_mouth import HandMouth, nearer_side
from .reading import first_outcome, signal_at, strategy_number

MOVING_SHARE = 0.1
"""Share of the hand's speed above which one object's speed means that the pile moves [-]; chosen."""

ARRIVED = 1e-5
"""Distance from its last position within which the reference has arrived [m]; chosen. It moves so far in 0.1 ms."""

SHORTEST_PUSH = 0.005
"""Least motion of the reference for a push to have a direction [m]; chosen."""


@dataclass(frozen=True, slots=True, eq=False)
class PushMotion:
    """Motion of n objects in F frames, from the first motion of the pile to the end of the push.

    A push that never reaches F_grasp waits at the end of its path. That time is left out, because a hand at rest does
    not push.

    In the hand's frame x is level and points along the fingers, y to the left and z up. The x axis is along the push,
    except for beta. Relative positions are measured from the middle of the hand's leading edge, so the hand is beneath
    an object with x < 0.

    Attributes:
        time: (F,) times of the frames [s].
        edge: (2,) middle of the leading edge relative to the tool, in the hand's frame [m].
        hand: (F, 2) middle of the leading edge in the scene, along the axes of the hand's frame [m].
        relative: (F, n, 2) centres of the objects in the hand's frame [m].
        objects: (n,) names of the objects.
        radius: Median radius of the objects [m]. The radius of an object is the geometric mean of its half extents.
        half_width: Half the width of the leading edge [m].
        length: Distance from the leading edge to the rear of the hand [m].
        axes: (2, 3) unit vectors of x and y in the scene.
        rigid: Whether the hand is a single body, which cannot close.
        nearer_side: Side on which a slanted wall is nearer: 1 left, -1 right, 0 neither.
    """

    time: Array
    edge: Array
    hand: Array
    relative: Array
    objects: tuple[str, ...]
    radius: float
    half_width: float
    length: float
    axes: Array
    rigid: bool
    nearer_side: int

    @classmethod
    def of(cls, recording: Recording) -> PushMotion | None:
        """Return the motion, or None if there was no push, nothing to push, or a pile that never moved."""
        push, along, axes = first_outcome(recording, "push"), _push_axes(recording), hand_axes(recording)
        chosen = [index for index, body in enumerate(recording.bodies) if body.role == "object" and body.shapes]
        if push is None or along is None or axes is None or not chosen:
            return None
        first = int(np.searchsorted(recording.frame_time, push["start"] - 1e-9))
        last = int(np.searchsorted(recording.frame_time, _end(recording, push, along) + 1e-9))
        if last - first < 2:
            return None
        tool = signal_at(recording, "tool_position", recording.frame_time[first:last])
        if tool is None:
            return None
        first = _first_motion(recording, chosen, slice(first, last), components(tool, along[0]))
        if last - first < 2:
            return None
        frames = slice(first, last)
        tool = tool[-(last - first) :]
        radius = float(np.median([_radius(recording.bodies[index].shapes[0]) for index in chosen]))
        mouth = HandMouth.of(recording, frames, tool, axes, depth=radius)
        if mouth is None or inner(tool[-1] - tool[0], along[0]) <= 0.0:
            return None
        edge = np.array([mouth.front, 0.5 * (mouth.left + mouth.right)])
        hand = rotated(axes, tool) + edge
        return cls(
            time=recording.frame_time[frames],
            edge=edge,
            hand=hand,
            relative=rotated(axes, recording.body_position[frames, chosen]) - hand[:, None],
            objects=tuple(recording.bodies[index].name for index in chosen),
            radius=radius,
            half_width=0.5 * mouth.width,
            length=mouth.front - mouth.rear,
            axes=axes,
            rigid=sum(body.role == "hand" for body in recording.bodies) == 1,
            nearer_side=nearer_side(recording, axes),
        )

    @property
    def hand_speed(self) -> float:
        """Median speed of the hand [m/s]: its sliding speed, even if a wall stops it at the end."""
        return float(np.median(np.linalg.norm(self.hand_velocity, axis=1)))

    @property
    def hand_velocity(self) -> Array:
        """(F-1, 2) velocities of the hand in the scene, along the axes of its frame [m/s]."""
        return np.diff(self.hand, axis=0) / np.diff(self.time)[:, None]

    @property
    def relative_velocity(self) -> Array:
        """(F-1, n, 2) mean velocities relative to the hand between two frames [m/s]."""
        return np.diff(self.relative, axis=0) / np.diff(self.time)[:, None, None]

    @property
    def absolute_velocity(self) -> Array:
        """(F-1, n, 2) velocities in the scene, along the axes of the hand's frame [m/s]."""
        return self.relative_velocity + self.hand_velocity[:, None]

    @property
    def midpoints(self) -> Array:
        """(F-1, n, 2) relative positions half-way between two frames [m], to which those velocities belong."""
        return 0.5 * (self.relative[1:] + self.relative[:-1])

    @property
    def before_mouth(self) -> NDArray[np.bool_]:
        """(F-1, n) flags of the objects ahead of the leading edge, within its width and at most two diameters away."""
        x, y = np.moveaxis(self.midpoints, -1, 0)
        return (x > 0.0) & (x <= 4.0 * self.radius) & (np.abs(y) <= self.half_width)

    @property
    def beside_mouth(self) -> NDArray[np.bool_]:
        """(F-1, n) flags of the objects ahead of the leading edge and beyond its ends."""
        x, y = np.moveaxis(self.midpoints, -1, 0)
        return (x > 0.0) & (np.abs(y) > self.half_width)

    @property
    def in_hand(self) -> NDArray[np.bool_]:
        """(F, n) flags of the objects whose centre is behind the leading edge and within its width, above the hand."""
        x, y = np.moveaxis(self.relative, -1, 0)
        return (x < 0.0) & (x > -self.length) & (np.abs(y) <= self.half_width)

    @property
    def at_edge(self) -> NDArray[np.bool_]:
        """(F, n) flags of the objects whose centre is at most a radius ahead of the leading edge, within its width."""
        x, y = np.moveaxis(self.relative, -1, 0)
        return (x >= 0.0) & (x <= self.radius) & (np.abs(y) <= self.half_width)


def hand_axes(recording: Recording) -> Array | None:
    """Return level unit vectors (2, 3) along the pushing fingers and to their left, or None if there was no push."""
    axes = _push_axes(recording)
    if axes is None:
        return None
    beta = math.radians(strategy_number(recording, "beta_deg", 0.0))
    x, y = axes
    return np.array([math.cos(beta) * x + math.sin(beta) * y, math.cos(beta) * y - math.sin(beta) * x])


def _push_axes(recording: Recording) -> Array | None:
    """Return unit vectors (2, 3) along the push and to its left, from the reference, which no contact deflects."""
    push = first_outcome(recording, "push")
    if push is None:
        return None
    ends = signal_at(recording, "reference_position", np.array([push["start"], push["end"]]))
    if ends is None:
        return None
    x, y, _ = ends[1] - ends[0]
    length = math.hypot(x, y)
    if length < SHORTEST_PUSH:
        return None
    return np.array([[x, y, 0.0], [-y, x, 0.0]]) / length


def _end(recording: Recording, push: Mapping[str, Any], axes: Array) -> float:
    """Return the end of the push [s], or the arrival of its reference if that is earlier."""
    during = (recording.signal_time >= push["start"] - 1e-9) & (recording.signal_time <= push["end"] + 1e-9)
    time = recording.signal_time[during]
    if not time.size:
        return float(push["end"])
    travelled = components(recording.signals["reference_position"][during][:, :3], axes[0])
    arrived = travelled[-1] - travelled < ARRIVED
    return float(min(push["end"], time[np.argmax(arrived)])) if arrived.any() else float(push["end"])


def _first_motion(recording: Recording, chosen: list[int], frames: slice, hand: Array) -> int:
    """Return the frame after which the first object moves, or the end of the push if none does.

    Args:
        recording: The attempt.
        chosen: Indices of the objects.
        frames: Frames of the push.
        hand: Position of the hand along the push in those frames [m].
    """
    time = recording.frame_time[frames]
    step = np.diff(recording.body_position[frames, chosen].astype(float), axis=0)
    speed = np.linalg.norm(step, axis=2).max(axis=1) / np.diff(time)
    moving = speed > MOVING_SHARE * (hand[-1] - hand[0]) / (time[-1] - time[0])
    return frames.start + int(np.argmax(moving)) if moving.any() else frames.stop


def _radius(shape: Shape) -> float:
    return math.cbrt(math.prod(shape.half_extents()))
