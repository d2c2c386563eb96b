"""A recording as the stream of commands that meshcat's viewer understands, without meshcat's server."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import umsgpack

from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.recording_parts import Body
from pilegrasp_ctrl.types import rotation_matrices
from pilegrasp_ctrl.viewer.scene.animation import clip, pose_tracks
from pilegrasp_ctrl.viewer.scene.overlays import tool_paths, wrist_wrench
from pilegrasp_ctrl.viewer.scene.shapes import body_looks, body_object, column_major

FOLDERS = {"arm": "Arm", "hand": "Hand", "object": "Objects", "support": "Support", "sensor": "Sensor"}
"""Folder of the scene tree for each role of a body."""

SCENE_PROPERTIES = (
    ("/Grid", "visible", False),
    ("/Axes", "visible", False),
    ("/Background", "visible", False),
    ("/Lights/PointLightNegativeX", "visible", False),
    ("/Lights/PointLightPositiveX", "visible", False),
    ("/Lights/AmbientLight/<object>", "intensity", 0.55),
    ("/Lights/FillLight/<object>", "intensity", 0.25),
    ("/Lights/SpotLight", "visible", True),
    ("/Lights/SpotLight/<object>", "castShadow", True),
    ("/Lights/SpotLight/<object>", "intensity", 0.55),
    ("/Lights/SpotLight/<object>", "angle", 0.6),
    ("/Lights/SpotLight/<object>", "penumbra", 1.0),
    ("/Cameras/default/rotated/<object>", "fov", 35.0),
)
"""Path, name and value of each property that differs from meshcat's default: no grid, axes or background, other lights,
and a narrower field of view."""


def node_path(index: int, body: Body) -> str:
    """Return the body's path in the scene tree.

    The index distinguishes names that differ only in replaced characters. It also keeps a name such as `__proto__` from
    becoming a key of a JavaScript object.
    """
    return f"/{FOLDERS[body.role]}/{index:02d} {re.sub(r'[^A-Za-z0-9_-]', '_', body.name)[:40]}"


def reach(body: Body) -> float:
    """Return the largest distance of the body's shapes from its frame [m]."""
    return max((float(np.linalg.norm(s.position) + np.linalg.norm(s.half_extents())) for s in body.shapes), default=0.0)


def commands(recording: Recording, starts: Sequence[float] = ()) -> list[dict[str, Any]]:
    """Return meshcat's commands, in order: lights, bodies with their first pose, overlays, one animation.

    The animation's clock is zero at the first frame; it does not run by itself.

    Args:
        recording: Recording.
        starts: Times at which the attempts of an order begin [s]; each has its own path of the tool.
    """
    times = (recording.frame_time - recording.frame_time[0]).astype(np.float32)
    duration = float(times[-1])
    looks = body_looks(recording)
    stream: list[dict[str, Any]] = [
        {"type": "set_property", "path": path, "property": name, "value": value}
        for path, name, value in SCENE_PROPERTIES
    ]
    clips = []
    for index, body in enumerate(recording.bodies):
        path = node_path(index, body)
        position, quaternion = recording.body_position[:, index], recording.body_quaternion[:, index]
        matrix = column_major([float(x) for x in position[0]], rotation_matrices(quaternion[0]))
        stream.append({"type": "set_object", "path": path, "object": body_object(body, looks[index])})
        stream.append({"type": "set_transform", "path": path, "matrix": matrix})
        tracks = pose_tracks(times, position, quaternion, reach(body))
        if tracks:
            clips.append(clip(path, tracks, duration))
    arrows, arrow_tracks = wrist_wrench(recording, times)
    stream += arrows + tool_paths(recording, starts)
    clips += [clip(path, tracks, duration) for path, tracks in arrow_tracks.items() if tracks]
    if clips:
        stream.append({"type": "set_animation", "path": "", "animations": clips, "options": {"play": False}})
    return stream


def pack(stream: Iterable[dict[str, Any]]) -> bytes:
    """Return the commands as MessagePack with single floats, each after its length (uint32, little-endian)."""
    messages = (umsgpack.packb(command, force_float_precision="single") for command in stream)
    return b"".join(struct.pack("<I", len(message)) + message for message in messages)


def unpack(content: bytes) -> list[dict[str, Any]]:
    """Return the commands that `pack` wrote; arrays stay MessagePack extensions."""
    stream, at = [], 0
    while at < len(content):
        (length,) = struct.unpack_from("<I", content, at)
        stream.append(umsgpack.unpackb(content[at + 4 : at + 4 + length]))
        at += 4 + length
    return stream
