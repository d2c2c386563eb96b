"""The camera: the box that it frames, and the side from which objects and hand are hidden least."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pilegrasp_ctrl.analysis.reading import signal_at
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.types import rotation_matrices
from pilegrasp_ctrl.viewer.summary import summarize

VIEWS = tuple(
    (side * azimuth, elevation) for side in (-1, 1) for azimuth in (90, 110, 70, 150) for elevation in (24, 42)
)
"""Directions from the scene to the camera: azimuth from +x and elevation [deg], the preferred ones first. A push runs
along +x, so the camera sees it from the side. It looks from the right, so that pages of many attempts look alike."""

RANK_COST = 0.01
"""Share of the points that a view must show more than the view before it in `VIEWS` to be preferred; chosen."""

FRAMES = 8
"""Number of frames, at equal distances in time, in which a view is judged; chosen."""

MAX_TARGETS = 20
"""Largest number of objects, and of bodies of the hand, whose visibility is judged; chosen."""

EYE_DISTANCE = 3.0
"""Distance from a point to the eye [m]: farther than anything in a scene."""

TIP_HEIGHT = np.array([0.0, 0.0, 0.02])
"""Displacement of the judged point from the tool [m], so that the table does not hide it."""

MARGIN = 0.06
"""Margin of the framed box around the bodies' frames [m]; chosen as about the size of an object."""


def directions() -> NDArray[np.float64]:
    """Return the unit vectors (V, 3) of `VIEWS`."""
    azimuth, elevation = np.deg2rad(np.array(VIEWS, dtype=float)).T
    return np.stack(
        [np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)], axis=1
    )


def action_box(recording: Recording) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the low and high corner (3,) [m] of the box to frame: hand and objects, without a few that roll away."""
    roles = np.array([body.role for body in recording.bodies])
    inside = []
    for role, share in (("hand", 2.0), ("object", 8.0)):
        points = recording.body_position[:, roles == role].reshape(-1, 3).astype(np.float64)
        if points.size:
            inside.append(np.percentile(points, [share, 100.0 - share], axis=0))
    if not inside:
        points = recording.body_position.reshape(-1, 3).astype(np.float64)
        inside.append(np.stack([points.min(axis=0), points.max(axis=0)]))
    low = np.min([box[0] for box in inside], axis=0) - MARGIN
    high = np.max([box[1] for box in inside], axis=0) + MARGIN
    return low, high


def _veil(
    recording: Recording, index: int, frame: int, eyes: NDArray[np.float64], points: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return how much a body's shapes hide points (P, 3) from eyes (V, 3): shares (V, P), by the slab test.

    An opaque shape hides all, and glass the square of its opacity, because much can be seen through it. A shape around
    the point, such as a joint around a knuckle, hides nothing.
    """
    rotation = rotation_matrices(recording.body_quaternion[frame, index])
    position = recording.body_position[frame, index].astype(np.float64)
    result = np.zeros((len(eyes), len(points)))
    for shape in recording.bodies[index].shapes:
        turn = rotation @ rotation_matrices(shape.quaternion)
        center = position + rotation @ np.asarray(shape.position)
        half = np.maximum(shape.half_extents(), 1e-4)
        start = ((points - center) @ turn)[None, :, :]
        ray = (eyes @ turn)[:, None, :] * EYE_DISTANCE
        ray = np.where(np.abs(ray) < 1e-9, 1e-9, ray)
        one, two = (-half - start) / ray, (half - start) / ray
        enter, leave = np.minimum(one, two).max(axis=-1), np.maximum(one, two).min(axis=-1)
        between = (enter < leave) & (enter > 0.0) & (enter < 1.0)
        result = np.maximum(result, shape.rgba[3] ** 2 * between)
    return result


def _spread(indices: list[int]) -> list[int]:
    return indices[:: len(indices) // MAX_TARGETS + 1]


def _moments(recording: Recording) -> list[int]:
    """Return the frames in which views are judged: some at equal distances, and the ends of the primitives."""
    times = recording.frame_time
    ends = [row.end for row in summarize(recording.meta).primitives]
    return [
        int(k)
        for k in np.searchsorted(times, [*np.linspace(times[0], times[-1], FRAMES), *ends]).clip(0, len(times) - 1)
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
        # The whole hand is no good target: the wrist hides its base from almost every side.
        tips = position[hand] if tool is None else tool[frame, None] + TIP_HEIGHT
        for points in (position[objects], tips):
            veil = np.zeros((len(candidates), len(points)))
            for index, body in enumerate(recording.bodies):
                if body.role in ("support", "arm", "sensor") and points.size:
                    veil = np.maximum(veil, _veil(recording, index, frame, candidates, points))
            hidden += veil.sum(axis=1) / max(1, len(points))
    return candidates[int(np.argmin(hidden / len(moments) + RANK_COST * np.arange(len(candidates))))]


def view(recording: Recording) -> dict[str, list[float]]:
    """Return the page's view: `low` and `high` corners of the framed box [m], and the `direction` to the camera."""
    low, high = action_box(recording)
    return {
        "low": np.round(low, 4).tolist(),
        "high": np.round(high, 4).tolist(),
        "direction": np.round(best_direction(recording), 4).tolist(),
    }
