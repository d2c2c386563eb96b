"""The pile as the pushing hand sees it: where the push goes, and the funnel in front of the hand."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pilegrasp_ctrl.analysis.meta import lookup, number
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.types import rotation_matrices
from pilegrasp_ctrl.viewer.overlays import at_frames
from pilegrasp_ctrl.viewer.summary import summarize

OPENING = np.deg2rad(20.0)
"""Of the funnel's sides against its middle line; the paper's Fig. 2 is a sketch without numbers."""

LENGTH = 0.25
"""Of the funnel [m]: the side of the frame in which the pile of 18 objects was dropped."""

_SHORTEST = 0.005


def push_frame(recording: Recording) -> dict[str, Any] | None:
    """Return the funnel of the first push; None where no push, tool or hand was recorded, or it went nowhere.

    The values: `start` and `end` of the push [s]; the `direction` in the table's plane in which the hand points, that
    of the push turned by beta; and, relative to the tool, the leading edge of the hand halfway through the push: its
    `front` along the direction, its `middle` to the left, and its `half` width, with the funnel's `opening` [rad] and
    `length`, all in metres.
    """
    phase = next((phase for phase in summarize(recording.meta).phases if phase.name == "push"), None)
    tool = at_frames(recording, "tool_position", 3)
    if phase is None or tool is None:
        return None
    first, last = np.searchsorted(recording.frame_time, (phase.start, phase.end)).clip(0, len(tool) - 1)
    way = tool[last, :2] - tool[first, :2]
    length = float(np.hypot(*way))
    if not _SHORTEST < length < 1e3:
        return None
    beta = np.deg2rad(number(lookup(recording.meta, "config.strategy.beta_deg")) or 0.0)
    along = np.array([[np.cos(beta), -np.sin(beta)], [np.sin(beta), np.cos(beta)]]) @ way / length
    axes = np.array([[*along, 0.0], [-along[1], along[0], 0.0]])
    boxes = _hand_boxes(recording, int(first + last) // 2, axes)
    if not len(boxes):
        return None
    center = boxes[:, 0] - axes @ tool[(first + last) // 2]
    front = float((center[:, 0] + boxes[:, 1, 0]).max())
    leading = center[:, 0] + boxes[:, 1, 0] > front - 0.02
    low, high = (center - boxes[:, 1])[leading, 1].min(), (center + boxes[:, 1])[leading, 1].max()
    return {
        "start": phase.start,
        "end": phase.end,
        "direction": np.round(along, 5).tolist(),
        "front": round(front, 4),
        "middle": round(float(low + high) / 2, 4),
        "half": round(float(high - low) / 2, 4),
        "opening": round(float(OPENING), 4),
        "length": LENGTH,
    }


def _hand_boxes(recording: Recording, frame: int, axes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return centres and half-extents (N, 2, 2) of the hand's shapes along the axes (2, 3) [m]."""
    boxes = []
    for index, body in enumerate(recording.bodies):
        if body.role != "hand":
            continue
        turn = rotation_matrices(recording.body_quaternion[frame, index])
        place = recording.body_position[frame, index].astype(np.float64)
        for shape in body.shapes:
            own = turn @ rotation_matrices(shape.quaternion)
            center = place + turn @ np.asarray(shape.position)
            boxes.append((axes @ center, np.abs(axes @ own) @ np.asarray(shape.half_extents())))
    return np.array(boxes).reshape(-1, 2, 2)
