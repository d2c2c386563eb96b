"""Motion as a few keys: tracks for three.js's animation mixer, thinned so that every pose error stays below a bound."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import umsgpack
from numpy.typing import NDArray

POSITION_TOLERANCE = 2e-4
"""Largest error of a drawn position [m]; chosen: a fifth of a millimetre cannot be seen."""

ROTATION_TOLERANCE = np.deg2rad(0.5)
"""Largest error of a drawn orientation [rad]; chosen."""

GRAIN = 2.0**-15
"""Unit to whose multiples values are rounded [m, 1]; rounded values compress to half their size."""

POSITION_ROUNDING = 0.5 * np.sqrt(3.0) * GRAIN
"""Error that rounding adds to a position [m]: half a grain in each of three numbers."""

ROTATION_ROUNDING = 2.0 * GRAIN
"""Error that rounding adds to an orientation [rad]: half a grain in each of four numbers, at twice the half-angle."""

MAX_SEGMENT = 4096
"""Largest number of points that are thinned as one; chosen: 2 min at 30 Hz."""

FLOAT32_ARRAY = 0x17
"""MessagePack extension that meshcat's decoder turns into a Float32Array (meshcat.geometry.threejs_type)."""

Array = NDArray[np.float32]
"""Array of single-precision floats, as three.js takes it."""


def packed(array: NDArray[Any]) -> umsgpack.Ext:
    """Return the array as the little-endian float32 block that meshcat's viewer decodes."""
    return umsgpack.Ext(FLOAT32_ARRAY, np.ascontiguousarray(array, dtype="<f4").tobytes())


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """Keys of one property of a scene node: `times` (K,) [s] and `values` (K, n), which three.js interpolates."""

    property: str
    kind: str
    times: Array
    values: Array

    def lower(self) -> dict[str, Any]:
        """Return the track as `THREE.AnimationClip.parse` reads it."""
        return {
            "name": f".{self.property}",
            "type": self.kind,
            "times": packed(self.times),
            "values": packed(np.round(self.values.astype(np.float64) / GRAIN) * GRAIN),
        }


def clip(path: str, tracks: list[Track], duration: float) -> dict[str, Any]:
    """Return one entry of a `set_animation` command; every clip lasts `duration` [s], so all end together."""
    return {
        "path": path,
        "clip": {"name": "default", "fps": 1, "duration": duration, "tracks": [track.lower() for track in tracks]},
    }


def slerp(start: NDArray[Any], end: NDArray[Any], fraction: NDArray[Any]) -> NDArray[np.float64]:
    """Return quaternions (N, 4) between two unit quaternions (4,) the short way round, as three.js interpolates."""
    cosine = float(start @ end)
    end, cosine = (end, cosine) if cosine >= 0.0 else (-end, -cosine)
    angle = np.arctan2(np.linalg.norm(end - cosine * start), cosine)
    fraction = fraction[:, None]
    if angle < 1e-6:
        mixed = (1.0 - fraction) * start + fraction * end
    else:
        mixed = np.sin((1.0 - fraction) * angle) * start + np.sin(fraction * angle) * end
    return mixed / np.linalg.norm(mixed, axis=1, keepdims=True)


def angle_between(a: NDArray[Any], b: NDArray[Any]) -> NDArray[np.float64]:
    """Return the angles [rad] between unit quaternions (..., 4); exact near zero, unlike an arc cosine."""
    chord = np.minimum(np.linalg.norm(a - b, axis=-1), np.linalg.norm(a + b, axis=-1))
    return 4.0 * np.arcsin(np.minimum(chord / 2.0, 1.0))


def thin(count: int, error: Callable[[int, int], NDArray[np.float64]], tolerance: float) -> NDArray[np.intp]:
    """Return the indices of `count` points that must be kept, given the errors of the line between any two of them.

    This is the algorithm of Ramer, Douglas and Peucker: it splits a segment at its largest error, until every segment
    holds the tolerance. The ends of segments of `MAX_SEGMENT` points are kept, so that the time is linear.
    """
    ends = [*range(0, count - 1, MAX_SEGMENT), count - 1]
    kept = set(ends)
    segments = list(pairwise(ends))
    while segments:
        first, last = segments.pop()
        if last - first < 2:
            continue
        errors = error(first, last)
        worst = int(np.argmax(errors))
        if errors[worst] > tolerance:
            middle = first + 1 + worst
            kept.add(middle)
            segments += [(first, middle), (middle, last)]
    return np.array(sorted(kept))


def _fraction(t: NDArray[np.float64], first: int, last: int) -> NDArray[np.float64]:
    # Times that differ in float64 may coincide in float32.
    return (t[first + 1 : last] - t[first]) / max(t[last] - t[first], np.finfo(np.float32).tiny)


def vector_track(name: str, times: Array, values: Array, tolerance: float) -> Track | None:
    """Return a thinned track of vectors (F, 3), or None if they never leave the first by more than the tolerance.

    At every time of `times` the linear interpolation is within `tolerance` (Euclidean) of the value.
    """
    t, x = times.astype(np.float64), values.astype(np.float64)
    if np.linalg.norm(x - x[0], axis=1).max() <= tolerance:
        return None

    def error(first: int, last: int) -> NDArray[np.float64]:
        fraction = _fraction(t, first, last)
        return np.linalg.norm(x[first] + fraction[:, None] * (x[last] - x[first]) - x[first + 1 : last], axis=1)

    kept = thin(len(t), error, tolerance)
    return Track(name, "vector3", times[kept], values[kept])


def rotation_track(times: Array, quaternions: Array, tolerance: float) -> Track | None:
    """Return a thinned track of wxyz quaternions (F, 4), or None if they stay within `tolerance` [rad] of the first.

    The track's values are in three.js's order, xyzw.
    """
    t, q = times.astype(np.float64), quaternions.astype(np.float64)
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    if angle_between(q, q[0]).max() <= tolerance:
        return None

    def error(first: int, last: int) -> NDArray[np.float64]:
        fraction = _fraction(t, first, last)
        return angle_between(slerp(q[first], q[last], fraction), q[first + 1 : last])

    kept = thin(len(t), error, tolerance)
    return Track("quaternion", "quaternion", times[kept], quaternions[kept][:, [1, 2, 3, 0]])


def pose_tracks(times: Array, position: Array, quaternion: Array, reach: float) -> list[Track]:
    """Return the tracks of a body's motion, none for a body at rest.

    `reach` [m] is the distance that the body's shapes extend from its frame. A long link gets a tighter angle than
    0.5°, so that the error of its far end is at most twice the position tolerance.
    """
    angle = min(ROTATION_TOLERANCE, 2.0 * POSITION_TOLERANCE / max(reach, 1e-9))
    tracks = (
        vector_track("position", times, position, POSITION_TOLERANCE - POSITION_ROUNDING),
        rotation_track(times, quaternion, max(angle - ROTATION_ROUNDING, 0.1 * angle)),
    )
    return [track for track in tracks if track is not None]
