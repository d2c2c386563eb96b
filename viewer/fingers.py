"""Soft fingers: chains of capsules that the page draws as one bent tube each."""

from __future__ import annotations

import re
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pilegrasp_ctrl.recording import Body, Recording
from pilegrasp_ctrl.types import rotation_matrices
from pilegrasp_ctrl.viewer.shapes import hex_color

_NUMBERED = re.compile(r"(.+)_(\d+)")


def chains(bodies: tuple[Body, ...]) -> list[list[int]]:
    """Return the indices of each finger's segments, from base to tip.

    A finger is a run of at least two bodies of the hand with one capsule each, numbered under one name, as in
    `index_1`, `index_2`.
    """
    found: list[list[int]] = []
    last: tuple[str, int] | None = None
    for index, body in enumerate(bodies):
        match = _NUMBERED.fullmatch(body.name)
        if body.role != "hand" or len(body.shapes) != 1 or body.shapes[0].kind != "capsule" or match is None:
            last = None
            continue
        stem, number = match[1], int(match[2])
        if last == (stem, number - 1):
            found[-1].append(index)
        else:
            found.append([index])
        last = (stem, number)
    return [chain for chain in found if len(chain) > 1]


def _ends(body: Body) -> NDArray[np.float64]:
    """Return the two ends (2, 3) of the capsule's axis in the body's frame [m]."""
    shape = body.shapes[0]
    axis = shape.size[1] * rotation_matrices(shape.quaternion)[:, 2]
    return np.asarray(shape.position) + np.stack([-axis, axis])


def tubes(recording: Recording, paths: list[str]) -> list[dict[str, Any]]:
    """Return what the page needs to draw the fingers, given the bodies' paths in the scene tree.

    Each finger has a `color` and `segments`, each with its `path`, its `radius` [m], and the `ends` of its axis in its
    own frame [m], the one nearer to the base first.
    """
    result = []
    for chain in chains(recording.bodies):
        ends = [_ends(recording.bodies[index]) for index in chain]
        placed = [
            recording.body_position[0, index] + own @ rotation_matrices(recording.body_quaternion[0, index]).T
            for index, own in zip(chain, ends, strict=True)
        ]
        middles = [points.mean(axis=0) for points in placed]
        # The far end of a segment is the one nearer to the next; the tip's is the one farther from the one before.
        turned = [
            np.linalg.norm(points[0] - after) < np.linalg.norm(points[1] - after)
            for points, (_, after) in zip(placed, pairwise(middles), strict=False)
        ]
        turned.append(np.linalg.norm(placed[-1][1] - middles[-2]) < np.linalg.norm(placed[-1][0] - middles[-2]))
        segments = [
            {
                "path": paths[index],
                "radius": round(recording.bodies[index].shapes[0].size[0], 5),
                "ends": np.round(own[::-1] if backward else own, 5).tolist(),
            }
            for index, own, backward in zip(chain, ends, turned, strict=True)
        ]
        result.append({"color": hex_color(recording.bodies[chain[0]].shapes[0].rgba), "segments": segments})
    return result
