"""Where to look from: at the objects and the hand's way, from the side on which least stands between."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pilegrasp_ctrl.analysis.reading import signal_at
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.types import rotation_matrices
from pilegrasp_ctrl.viewer.summary import summarize

# Directions from the scene to the camera (azimuth from +x, elevation) in degrees, the preferred ones first: a push runs
# along +x, so it is seen from the side, and from the right, so that pages of many attempts look alike.
VIEWS = tuple(
    (side * azimuth, elevation) for side in (-1, 1) for azimuth in (90, 110, 70, 150) for elevation in (24, 42)
)

_FRAMES = 8
_TARGETS = 20
_FAR = 3.0
_ABOVE = np.array([0.0, 0.0, 0.02])


def directions() -> NDArray[np.float64]:
    """Return the unit vectors (V, 3) of `VIEWS`."""
    azimuth, elevation = np.deg2rad(np.array(VIEWS, dtype=float)).T
    return np.stack(
        [np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)], axis=1
    )


def action_box(recording: Recording) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the corners (3,), (3,) [m] of the box to frame: hand and objects, without the few that roll away."""
    roles = np.array([body.role for body in recording.bodies])
    inside = []
    for role, share in (("hand", 2.0), ("object", 8.0)):
        points = recording.body_position[:, roles == role].reshape(-1, 3).astype(np.float64)
        if points.size:
            inside.append(np.percentile(points, [share, 100.0 - share], axis=0))
    if not inside:
        points = recording.body_position.reshape(-1, 3).astype(np.float64)
        inside.append(np.stack([points.min(axis=0), points.max(axis=0)]))
    low = np.min([box[0] for box in inside], axis=0) - 0.06
    high = np.max([box[1] for box in inside], axis=0) + 0.06
    return low, high


def _veil(
    recording: Recording, index: int, frame: int, eyes: NDArray[np.float64], points: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return (V, P): what the body's shapes take from the sight of a point (P, 3) by an eye (V, 3); the slab test.

    It is 1 for an opaque shape and the square of the opacity for glass, through which much can still be seen. A shape
    around the point, as the joint is around a knuckle, is no obstacle.
    """
    rotation = rotation_matrices(recording.body_quaternion[frame, index])
    position = recording.body_position[frame, index].astype(np.float64)
    result = np.zeros((len(eyes), len(points)))
    for shape in recording.bodies[index].shapes:
        turn = rotation @ rotation_matrices(shape.quaternion)
        center = position + rotation @ np.asarray(shape.position)
        half = np.maximum(shape.half_extents(), 1e-4)
        start = ((points - center) @ turn)[None, :, :]
        ray = (eyes @ turn)[:, None, :] * _FAR
        ray = np.where(np.abs(ray) < 1e-9, 1e-9, ray)
        one, two = (-half - start) / ray, (half - start) / ray
        enter, leave = np.minimum(one, two).max(axis=-1), np.maximum(one, two).min(axis=-1)
        between = (enter < leave) & (enter > 0.0) & (enter < 1.0)
        result = np.maximum(result, shape.rgba[3] ** 2 * between)
    return result


def _spread(indices: list[int]) -> list[int]:
    return indices[:: len(indices) // _TARGETS + 1]


def _moments(recording: Recording) -> list[int]:
    """Return the frames that must be seen: some at equal distances, and the ends of the primitives."""
    times = recording.frame_time
    ends = [row.end for row in summarize(recording.meta).primitives]
    return [
        int(k)
        for k in np.searchsorted(times, [*np.linspace(times[0], times[-1], _FRAMES), *ends]).clip(0, len(times) - 1)
    ]


def best_direction(recording: Recording) -> NDArray[np.float64]:
    """Return the unit vector (3,) from the scene to the camera from which objects and fingertips are hidden least."""
    candidates = directions()
    roles = [body.role for body in recording.bodies]
    objects = _spread([i for i, role in enumerate(roles) if role == "object"])
    hand = _spread([i for i, role in enumerate(roles) if role == "hand"])
    tool = signal_at(recording, "tool_position", recording.frame_time)
    moments = _moments(recording)
    hidden = np.zeros(len(candidates))
    for frame in moments:
        position = recording.body_position[frame].astype(np.float64)
        # Not the whole hand: the wrist hides its root from almost everywhere.
        tips = position[hand] if tool is None else tool[frame, None] + _ABOVE
        for points in (position[objects], tips):
            veil = np.zeros((len(candidates), len(points)))
            for index, body in enumerate(recording.bodies):
                if body.role in ("support", "arm", "sensor") and points.size:
                    veil = np.maximum(veil, _veil(recording, index, frame, candidates, points))
            hidden += veil.sum(axis=1) / max(1, len(points))
    # A view one place down the list must hide one part in a hundred less.
    return candidates[int(np.argmin(hidden / len(moments) + 0.01 * np.arange(len(candidates))))]


def view(recording: Recording) -> dict[str, list[float]]:
    """Return what the page frames: `low` and `high` corners of a box [m] and the `direction` to look from."""
    low, high = action_box(recording)
    return {
        "low": np.round(low, 4).tolist(),
        "high": np.round(high, 4).tolist(),
        "direction": np.round(best_direction(recording), 4).tolist(),
    }
