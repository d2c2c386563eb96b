"""Where to look from: at the objects and the hand's way, from the side on which least stands between."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.viewer.shapes import quaternion_matrix

# Directions from the scene to the camera (azimuth from +x, elevation) in degrees, the preferred ones first: a push runs
# along +x, so it is seen from the side and a little from behind the hand.
VIEWS = tuple(
    (azimuth, elevation) for elevation in (22, 38, 60) for azimuth in (-65, 65, -115, 115, -90, 90, -150, 150)
)

_FRAMES = 12
_TARGETS = 20
_FAR = 3.0


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
    """Return (V, P): how opaque the body's shapes are between a point (P, 3) and an eye (V, 3); the slab test."""
    rotation = quaternion_matrix(recording.body_quaternion[frame, index])
    position = recording.body_position[frame, index].astype(np.float64)
    result = np.zeros((len(eyes), len(points)))
    for shape in recording.bodies[index].shapes:
        turn = rotation @ quaternion_matrix(shape.quaternion)
        center = position + rotation @ np.asarray(shape.position)
        half = np.maximum(shape.half_extents(), 1e-4)
        start = ((points - center) @ turn)[None, :, :]
        ray = (eyes @ turn)[:, None, :] * _FAR
        ray = np.where(np.abs(ray) < 1e-9, 1e-9, ray)
        one, two = (-half - start) / ray, (half - start) / ray
        enter, leave = np.minimum(one, two).max(axis=-1), np.maximum(one, two).min(axis=-1)
        between = (enter < leave) & (leave > 0.0) & (enter < 1.0)
        result = np.maximum(result, shape.rgba[3] * between)
    return result


def _spread(indices: list[int]) -> list[int]:
    return indices[:: len(indices) // _TARGETS + 1]


def best_direction(recording: Recording) -> NDArray[np.float64]:
    """Return the unit vector (3,) from the scene to the camera from which objects and hand are hidden least."""
    candidates = directions()
    roles = [body.role for body in recording.bodies]
    aims = [i for wanted in ("object", "hand") for i in _spread([i for i, role in enumerate(roles) if role == wanted])]
    hidden = np.zeros(len(candidates))
    for frame in np.linspace(0, len(recording.frame_time) - 1, _FRAMES).astype(int):
        points = recording.body_position[frame, aims].astype(np.float64)
        veil = np.zeros((len(candidates), len(points)))
        for index, body in enumerate(recording.bodies):
            if body.role in ("support", "arm", "sensor") and points.size:
                veil = np.maximum(veil, _veil(recording, index, int(frame), candidates, points))
        hidden += veil.sum(axis=1)
    # A view one place down the list must hide one part in a hundred less.
    worth = hidden / max(1, _FRAMES * len(aims)) + 0.01 * np.arange(len(candidates))
    return candidates[int(np.argmin(worth))]


def view(recording: Recording) -> dict[str, list[float]]:
    """Return what the page frames: `low` and `high` corners of a box [m] and the `direction` to look from."""
    low, high = action_box(recording)
    return {
        "low": np.round(low, 4).tolist(),
        "high": np.round(high, 4).tolist(),
        "direction": np.round(best_direction(recording), 4).tolist(),
    }
