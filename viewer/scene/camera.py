"""The camera: the box that it frames, and the side from which objects and hand are hidden least."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pilegrasp_ctrl.analysis.reading import signal_at
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.recording_parts import Shape
from pilegrasp_ctrl.types import rotation_matrices
from pilegrasp_ctrl.viewer.page.summary import primitive_rows

View = dict[str, list[float]]
"""Boxes to frame and the direction to the camera, as `view` returns them."""

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

MAX_COVERS = 100
"""Largest number of shapes that may hide a target; chosen, several times those of an arm, a table and walls."""

MAX_ENDS = 100
"""Largest number of ends of primitives in which a view is judged; chosen above those of an order of 14 attempts."""

EYE_DISTANCE = 3.0
"""Distance from a point to the eye [m]: farther than anything in a scene."""

TIP_HEIGHT = np.array([0.0, 0.0, 0.02])
"""Displacement of the judged point from the tool [m], so that the table does not hide it."""

MAX_ARM_DISTANCE = 2.0
"""Largest distance along an axis, from the middle of the action, of a link that the whole view shows [m]; chosen above
the reach of an arm."""

ARM_MARGIN = 0.14
"""Margin of the framed box around the frames of the arm's links [m]; chosen as about the radius of a base."""

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
    recording: Recording,
    cover: tuple[int, Shape],
    frame: int,
    eyes: NDArray[np.float64],
    points: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return how much a shape of a body hides points (P, 3) from eyes (V, 3): shares (V, P), by the slab test.

    An opaque shape hides all, and glass the square of its opacity, because much can be seen through it. A shape around
    the point, such as a joint around a knuckle, hides nothing.
    """
    index, shape = cover
    rotation = rotation_matrices(recording.body_quaternion[frame, index])
    position = recording.body_position[frame, index].astype(np.float64)
    turn = rotation @ rotation_matrices(shape.quaternion)
    center = position + rotation @ np.asarray(shape.position)
    half = np.maximum(shape.half_extents(), 1e-4)
    start = ((points - center) @ turn)[None, :, :]
    ray = (eyes @ turn)[:, None, :] * EYE_DISTANCE
    ray = np.where(np.abs(ray) < 1e-9, 1e-9, ray)
    one, two = (-half - start) / ray, (half - start) / ray
    enter, leave = np.minimum(one, two).max(axis=-1), np.maximum(one, two).min(axis=-1)
    between = (enter < leave) & (enter > 0.0) & (enter < 1.0)
    return np.asarray(shape.rgba[3] ** 2 * between)


def _spread(indices: list[int]) -> list[int]:
    return indices[:: len(indices) // MAX_TARGETS + 1]


def _covers(recording: Recording) -> list[tuple[int, Shape]]:
    """Return the shapes that may hide something, each with the index of its body; at most `MAX_COVERS`."""
    shapes = [
        (index, shape)
        for index, body in enumerate(recording.bodies)
        if body.role in ("support", "arm", "sensor")
        for shape in body.shapes
    ]
    return shapes[:: len(shapes) // MAX_COVERS + 1]


def _moments(recording: Recording) -> list[int]:
    """Return the frames in which views are judged: some at equal distances, and ends of primitives."""
    times = recording.frame_time
    ends = [row.end for row in primitive_rows(recording.meta.get("outcomes"))]
    ends = ends[:: len(ends) // MAX_ENDS + 1]
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
    moments, covers = _moments(recording), _covers(recording)
    hidden = np.zeros(len(candidates))
    for frame in moments:
        position = recording.body_position[frame].astype(np.float64)
        # The whole hand is no good target: the wrist hides its base from almost every side.
        tips = position[hand] if tool is None else tool[frame, None] + TIP_HEIGHT
        for points in (position[objects], tips):
            veil = np.zeros((len(candidates), len(points)))
            for cover in covers if points.size else ():
                veil = np.maximum(veil, _veil(recording, cover, frame, candidates, points))
            hidden += veil.sum(axis=1) / max(1, len(points))
    return candidates[int(np.argmin(hidden / len(moments) + RANK_COST * np.arange(len(candidates))))]


def base_box(recording: Recording) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the low and high corner (3,) [m] of the box around the action and the arm's links, in all frames."""
    low, high = action_box(recording)
    arm = [index for index, body in enumerate(recording.bodies) if body.role == "arm"]
    points = recording.body_position[:, arm].reshape(-1, 3).astype(np.float64)
    # An arm at a corner of a huge scene would make everything small.
    points = points[(np.abs(points - 0.5 * (low + high)) < MAX_ARM_DISTANCE).all(axis=1)]
    if not points.size:
        return low, high
    return np.minimum(low, points.min(axis=0) - ARM_MARGIN), np.maximum(high, points.max(axis=0) + ARM_MARGIN)


def view(recording: Recording) -> View:
    """Return the page's view of a recording.

    Keys:
        low: Low corner of the box around hand and objects [m].
        high: High corner of that box [m].
        outer_low: Low corner of the box that holds the arm, too [m].
        outer_high: High corner of that box [m].
        direction: Unit vector from the scene to the camera.
    """
    (low, high), (outer_low, outer_high) = action_box(recording), base_box(recording)
    corners = {"low": low, "high": high, "outer_low": outer_low, "outer_high": outer_high}
    return {key: np.round(value, 4).tolist() for key, value in corners.items()} | {
        "direction": np.round(best_direction(recording), 4).tolist()
    }


def joined(views: Sequence[View]) -> View:
    """Return one view for several recordings: boxes around all, and the direction of the first."""
    found: View = {"direction": views[0]["direction"]}
    for key in ("low", "outer_low"):
        found[key] = np.min([view[key] for view in views], axis=0).tolist()
    for key in ("high", "outer_high"):
        found[key] = np.max([view[key] for view in views], axis=0).tolist()
    return found
