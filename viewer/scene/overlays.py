"""The overlays of a scene: the wrench on the hand as arrows, the path of the tool as a line, and the contact forces."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pilegrasp_ctrl.analysis.reading import signal_at
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.viewer.scene.animation import Track, packed, pose_tracks, vector_track
from pilegrasp_ctrl.viewer.scene.shapes import column_major, group, material

METERS_PER_NEWTON = 0.01
"""Length of an arrow of force [m/N]; chosen: an F_grasp of 17 N is about as long as the hand."""

METERS_PER_NEWTON_METER = 0.1
"""Length of an arrow of moment [m/(N·m)]; chosen."""

FORCE_COLOR, MOMENT_COLOR = 0xD62728, 0x8E24AA
"""Colours of the arrows of force and moment, red and purple [0xRRGGBB]; chosen."""

TOOL_COLOR, REFERENCE_COLOR = 0x3D9BFF, 0xFFD400
"""Colours of the paths of the tool and of its reference, blue and yellow [0xRRGGBB]; chosen to stand out on the dark
table."""

SHAFT_RADIUS = 0.006
"""Radius of an arrow's shaft [m]; chosen. A short arrow is thinner."""

HEAD_LENGTH = 0.04
"""Length of an arrow's head [m]; chosen. A short arrow has a shorter head."""

MAX_ARROW_LENGTH = 0.6
"""Length at which an arrow is cut [m]; chosen."""

MIN_ARROW_LENGTH = 1e-4
"""Length of an arrow without force [m]; chosen, because a scale of zero has no inverse."""

MIN_FORCE = 0.2
"""Force below which an arrow keeps its direction [N], because noise would turn it; chosen."""

CONTACT_METERS, CONTACT_NEWTONS = 1e-4, 1e-2
"""Units of the whole numbers in a block of contacts [m, N]; 16 bits hold 3.2 m and 327 N."""

MAX_INT16 = 32767
"""Largest 16-bit number, 2^15 - 1."""


def direction_quaternions(vectors: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return wxyz quaternions (F, 4) that turn +z into forces (F, 3) [N]; a small force keeps the last direction."""
    length = np.linalg.norm(vectors, axis=1)
    direction = np.where(length[:, None] > MIN_FORCE, vectors / np.maximum(length, 1e-9)[:, None], np.nan)
    last = np.array([0.0, 0.0, 1.0])
    for row in direction:
        if np.isnan(row[0]):
            row[:] = last
        last = row
    x, y, z = direction.T
    # Half-way quaternion between +z and the direction; straight down is a half turn about x.
    quaternion = np.stack([1.0 + z, -y, x, np.zeros_like(z)], axis=1)
    quaternion[z < -0.9999] = (0.0, 1.0, 0.0, 0.0)
    return (quaternion / np.linalg.norm(quaternion, axis=1, keepdims=True)).astype(np.float32)


def _arrow_parts(color: int) -> tuple[dict[str, Any], dict[str, Any]]:
    # The arrow is drawn over everything, because the hand would hide it.
    look = material("m0", color, type="MeshBasicMaterial", depthTest=False, transparent=True, opacity=0.9)
    upright = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])

    def part(geometry: dict[str, Any], height: float) -> dict[str, Any]:
        mesh = {
            "type": "Mesh",
            "geometry": "g0",
            "material": "m0",
            "matrix": column_major((0.0, 0.0, height), upright),
            "renderOrder": 10,
        }
        return group([mesh], [geometry | {"uuid": "g0"}], [look])

    shaft = {"type": "CylinderGeometry", "radiusTop": 1.0, "radiusBottom": 1.0, "height": 1.0, "radialSegments": 12}
    head = {"type": "ConeGeometry", "radius": 0.4, "height": 1.0, "radialSegments": 20}
    return part(shaft, 0.5), part(head, 0.5)


Drawing = tuple[list[dict[str, Any]], dict[str, list[Track]]]
"""Commands that draw something, and the tracks that move it."""


def _arrow(
    root: str, times: NDArray[np.float32], origin: NDArray[np.float64], vectors: NDArray[np.float64], color: int
) -> Drawing:
    """Return an arrow along the vectors (F, 3) [m] from the origins (F, 3) [m], cut at `MAX_ARROW_LENGTH`."""
    length = np.clip(np.linalg.norm(vectors, axis=1), MIN_ARROW_LENGTH, MAX_ARROW_LENGTH)
    head = np.minimum(HEAD_LENGTH, length / 2)
    width = np.minimum(SHAFT_RADIUS, length / 6)
    shaft = np.stack([width, width, length - head], axis=1).astype(np.float32)
    place = np.stack([np.zeros_like(head), np.zeros_like(head), length - head], axis=1).astype(np.float32)
    size = np.repeat(head[:, None], 3, axis=1).astype(np.float32)
    turn = direction_quaternions(vectors / METERS_PER_NEWTON)

    objects = [
        {"type": "set_object", "path": f"{root}/{name}", "object": part}
        for name, part in zip(("shaft", "head"), _arrow_parts(color), strict=True)
    ]
    starts = [
        {"type": "set_property", "path": path, "property": name, "value": [float(x) for x in value]}
        for path, name, value in (
            (root, "position", origin[0]),
            (root, "quaternion", turn[0][[1, 2, 3, 0]]),
            (f"{root}/shaft", "scale", shaft[0]),
            (f"{root}/head", "scale", size[0]),
            (f"{root}/head", "position", place[0]),
        )
    ]
    millimeter = 1e-3
    tracks: dict[str, list[Track | None]] = {
        root: [*pose_tracks(times, origin.astype(np.float32), turn, reach=0.02)],
        f"{root}/shaft": [vector_track("scale", times, shaft, millimeter)],
        f"{root}/head": [
            vector_track("position", times, place, millimeter),
            vector_track("scale", times, size, millimeter),
        ],
    }
    return objects + starts, {path: [t for t in some if t is not None] for path, some in tracks.items()}


def wrist_wrench(recording: Recording, times: NDArray[np.float32]) -> Drawing:
    """Return two arrows at the wrist sensor, the force and the moment on the hand; nothing without a wrench.

    The force has the direction in which the environment pushes the hand, 1 cm for a newton. The moment lies along the
    axis about which the environment turns the hand, 10 cm for a newton metre. Without a sensor's body
    the arrows are at the tool.
    """
    wrench = signal_at(recording, "wrench", recording.frame_time, 6)
    sensors = [index for index, body in enumerate(recording.bodies) if body.role == "sensor"]
    origin = (
        recording.body_position[:, sensors[0]].astype(np.float64)
        if sensors
        else signal_at(recording, "tool_position", recording.frame_time, 3)
    )
    if wrench is None or origin is None:
        return [], {}
    drawn: list[dict[str, Any]] = []
    tracks: dict[str, list[Track]] = {}
    for name, part, scale, color in (
        ("force", wrench[:, :3], METERS_PER_NEWTON, FORCE_COLOR),
        ("moment", wrench[:, 3:], METERS_PER_NEWTON_METER, MOMENT_COLOR),
    ):
        commands, moving = _arrow(f"/Overlays/wrench/{name}", times, origin, scale * part, color)
        drawn += commands
        tracks |= moving
    return drawn, tracks


def tool_paths(recording: Recording, starts: Sequence[float] = ()) -> list[dict[str, Any]]:
    """Return the commands that draw the paths of the tool and of its reference, if they were recorded.

    Args:
        recording: Recording.
        starts: Times at which the attempts of an order begin [s]; each has a path of its own.
    """
    time = recording.frame_time
    bounds = [0, *np.searchsorted(time, sorted(starts)[1:]).tolist(), time.size]
    drawn = []
    for name, signal, color in (
        ("reference", "reference_position", REFERENCE_COLOR),
        ("tool", "tool_position", TOOL_COLOR),
    ):
        path = signal_at(recording, signal, time, 3)
        for number, (first, end) in enumerate(pairwise(bounds)):
            if path is None or end - first < 2:
                continue
            rows = slice(first, end)
            track = vector_track("position", time[rows].astype(np.float32), path[rows].astype(np.float32), 2e-4)
            if track is not None:
                drawn.append(_line(f"/Overlays/paths/{number:02d}/{name}", track, color))
    return drawn


def _line(path: str, track: Track, color: int) -> dict[str, Any]:
    geometry = {"uuid": "g0", "type": "BufferGeometry", "data": {"attributes": {"position": _points(track)}}}
    look = {"uuid": "m0", "type": "LineBasicMaterial", "color": color}
    document = group([{"type": "Line", "geometry": "g0", "material": "m0"}], [geometry], [look])
    return {"type": "set_object", "path": path, "object": document}


def _points(track: Track) -> dict[str, Any]:
    return {"itemSize": 3, "type": "Float32Array", "array": packed(track.values), "normalized": False}


def contact_block(recording: Recording) -> bytes:
    """Return the contacts as bytes that the page's script reads; nothing if none were recorded.

    All numbers are little-endian. The block holds F as uint32, then the number of contacts of each frame as uint16.
    For all contacts follow the positions [0.1 mm] and the forces on the first bodies [0.01 N], three int16 each, then
    the two bodies' numbers in the recording, two uint16 each. One byte each ends the block: 0 if the first body belongs
    to the arm or the hand, 1 if it is an object on a support, 2 between two objects. Contacts beyond 3.2 m are left
    out, and forces are cut at 327 N.
    """
    contacts = recording.contacts
    if contacts is None:
        return b""
    near = (np.abs(contacts.position) < CONTACT_METERS * MAX_INT16).all(axis=1)
    frame = np.repeat(np.arange(contacts.frames), np.diff(contacts.start))
    count = np.bincount(frame[near], minlength=contacts.frames).clip(0, 65535)
    movable = np.array([body.role == "object" for body in recording.bodies])
    arm_or_hand = np.array([body.role in ("arm", "hand", "sensor") for body in recording.bodies])
    first, second = contacts.bodies[near].T
    code = np.where(arm_or_hand[first], 0, np.where(movable[first] & movable[second], 2, 1))
    force = np.clip(contacts.force[near].astype(np.float64) / CONTACT_NEWTONS, -MAX_INT16, MAX_INT16)
    return b"".join(
        (
            struct.pack("<I", contacts.frames),
            count.astype("<u2").tobytes(),
            np.round(contacts.position[near] / CONTACT_METERS).astype("<i2").tobytes(),
            np.round(force).astype("<i2").tobytes(),
            contacts.bodies[near].clip(0, 65535).astype("<u2").tobytes(),
            code.astype("u1").tobytes(),
        )
    )
