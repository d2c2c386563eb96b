"""A recording as an MCAP file for Foxglove: bodies, contacts, signals and events on one clock.

The messages are JSON of Foxglove's own schemas (docs.foxglove.dev/docs/sdk/schemas), so that its panels show them.
"""

from __future__ import annotations

import importlib.util
import io
import json
import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from pilegrasp_ctrl.analysis.reading import plain
from pilegrasp_ctrl.exceptions import ExportError
from pilegrasp_ctrl.files import write_output
from pilegrasp_ctrl.recording import Recording, Shape
from pilegrasp_ctrl.viewer.page.summary import primitive_rows
from pilegrasp_ctrl.viewer.scene.shapes import ENDLESS_PLANE

ROOT = "world"
"""Name of the scene's frame."""
_TIME = {"type": "object", "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}}}
_LEVELS = {False: 2, True: 3}
"""Foxglove's levels of a log: information, warning."""

Message = tuple[float, str, dict[str, Any]]
"""Time [s], topic and content."""


def require_mcap() -> None:
    """Check that the library for MCAP files is installed.

    Raises:
        ExportError: It is not.
    """
    if importlib.util.find_spec("mcap") is None:
        raise ExportError("an .mcap file needs the package mcap; install it with `pip install 'pilegrasp[export]'`")


def write_mcap(recording: Recording, path: str | os.PathLike[str]) -> None:
    """Write the recording for Foxglove, all of it or nothing; equal recordings give equal bytes.

    Topics are `/scene` (foxglove.SceneUpdate), `/tf` (foxglove.FrameTransforms), `/contacts`, `/events` (foxglove.Log)
    and `/signals/NAME` with the values in "value", or in "0", "1" and so on.

    Raises:
        ExportError: The library is missing, or the path cannot be written.
    """
    require_mcap()
    from mcap.writer import CompressionType, Writer

    file = io.BytesIO()
    writer = Writer(file, compression=CompressionType.LZ4)
    writer.start(library="pilegrasp")
    schemas: dict[str, int] = {}
    channels: dict[str, int] = {}
    messages = sorted(_messages(recording), key=lambda message: message[0])
    first = min((time for time, _, _ in messages), default=0.0)
    for time, topic, content in messages:
        schema = SCHEMAS.get(topic, "pilegrasp.Signal")
        if schema not in schemas:
            schemas[schema] = writer.register_schema(schema, "jsonschema", _schema(schema))
        if topic not in channels:
            channels[topic] = writer.register_channel(topic, "json", schemas[schema])
        # A log's time is not negative; that of a recording may be.
        stamp = round(1e9 * (time - min(first, 0.0)))
        writer.add_message(channels[topic], stamp, json.dumps(content, separators=(",", ":")).encode(), stamp)
    writer.finish()
    write_output(Path(path), file.getvalue(), "recording")


SCHEMAS = {
    "/scene": "foxglove.SceneUpdate",
    "/contacts": "foxglove.SceneUpdate",
    "/tf": "foxglove.FrameTransforms",
    "/events": "foxglove.Log",
}
"""Schema of each topic that is not a signal."""


_PROPERTIES: dict[str, dict[str, Any]] = {
    "foxglove.SceneUpdate": {"entities": {"type": "array", "items": {"type": "object"}}},
    "foxglove.FrameTransforms": {"transforms": {"type": "array", "items": {"type": "object"}}},
    "foxglove.Log": {"timestamp": _TIME, "level": {"type": "integer"}, "message": {"type": "string"}},
}


def _schema(name: str) -> bytes:
    """Return the schema's title and its lists; Foxglove knows the rest of its own schemas by their names."""
    return json.dumps({"title": name, "type": "object", "properties": _PROPERTIES.get(name, {})}).encode()


def _messages(recording: Recording) -> Iterator[Message]:
    start = float(recording.frame_time[0]) if recording.frame_time.size else 0.0
    yield start, "/scene", {"deletions": [], "entities": [_entity(start, *named) for named in _named(recording)]}
    yield from _poses(recording)
    yield from _contacts(recording)
    for name, values in recording.signals.items():
        for time, value in zip(recording.signal_time.tolist(), values.tolist(), strict=True):
            columns = value if values.ndim > 1 else [value]
            keys = map(str, range(len(columns))) if values.ndim > 1 else ["value"]
            yield time, f"/signals/{name}", dict(zip(keys, columns, strict=True))
    for row in primitive_rows(recording.meta.get("outcomes")):
        message = f"{plain(row.name)}: {plain(row.trigger)}"
        log = {"timestamp": _stamp(row.end), "level": _LEVELS[row.failed], "message": message, "name": "pilegrasp"}
        yield row.end, "/events", log


def _named(recording: Recording) -> Iterator[tuple[str, Sequence[Shape]]]:
    for index, body in enumerate(recording.bodies):
        yield f"{index} {body.name}", body.shapes


def _stamp(time: float) -> dict[str, int]:
    whole, rest = divmod(round(1e9 * time), 10**9)
    return {"sec": whole, "nsec": rest}


def _vector(values: Sequence[float]) -> dict[str, float]:
    return dict(zip("xyz", map(float, values), strict=True))


def _turn(quaternion: Sequence[float]) -> dict[str, float]:
    return dict(zip("wxyz", map(float, quaternion), strict=True))


def _poses(recording: Recording) -> Iterator[Message]:
    names = [name for name, _ in _named(recording)]
    positions, quaternions = recording.body_position.tolist(), recording.body_quaternion.tolist()
    for time, places, turns in zip(recording.frame_time.tolist(), positions, quaternions, strict=True):
        stamp = _stamp(time)
        transforms = [
            {
                "timestamp": stamp,
                "parent_frame_id": ROOT,
                "child_frame_id": name,
                "translation": _vector(place),
                "rotation": _turn(turn),
            }
            for name, place, turn in zip(names, places, turns, strict=True)
        ]
        yield time, "/tf", {"transforms": transforms}


def _entity(time: float, name: str, shapes: Sequence[Shape]) -> dict[str, Any]:
    entity: dict[str, Any] = {
        "timestamp": _stamp(time),
        "frame_id": name,
        "id": name,
        "lifetime": {"sec": 0, "nsec": 0},
        "frame_locked": True,
        "metadata": [],
        **{kind: [] for kind in ("arrows", "cubes", "spheres", "cylinders", "lines", "triangles", "texts", "models")},
    }
    for shape in shapes:
        for kind, part in _PARTS[shape.kind](shape):
            entity[kind].append(part)
    return entity


Part = tuple[str, dict[str, Any]]


def _part(shape: Shape, size: Sequence[float], along: float = 0.0) -> dict[str, Any]:
    """Return a part of full `size` [m], shifted by `along` on the z axis of its shape [m]."""
    w, x, y, z = shape.quaternion
    axis = (2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y))
    position = [place + along * part for place, part in zip(shape.position, axis, strict=True)]
    return {
        "pose": {"position": _vector(position), "orientation": _turn(shape.quaternion)},
        "size": _vector(size),
        "color": dict(zip("rgba", shape.rgba, strict=True)),
    }


def _round(shape: Shape, size: Sequence[float]) -> list[Part]:
    return [("spheres", _part(shape, [2.0 * radius for radius in size]))]


def _cylinder(shape: Shape) -> list[Part]:
    radius, half = shape.size
    full = _part(shape, [2.0 * radius, 2.0 * radius, 2.0 * half])
    return [("cylinders", full | {"bottom_scale": 1.0, "top_scale": 1.0})]


def _capsule(shape: Shape) -> list[Part]:
    radius, half = shape.size
    caps = [("spheres", _part(shape, [2.0 * radius] * 3, along)) for along in (-half, half)]
    return _cylinder(shape) + caps


def _cube(shape: Shape) -> list[Part]:
    return [("cubes", _part(shape, [2.0 * half for half in shape.size]))]


def _plane(shape: Shape) -> list[Part]:
    return [("cubes", _part(shape, [*(2.0 * (half or ENDLESS_PLANE) for half in shape.size), 0.001]))]


def _mesh(shape: Shape) -> list[Part]:
    part = _part(shape, (0.0, 0.0, 0.0))
    del part["size"]
    corners = {
        "points": list(map(_vector, shape.vertices)),
        "indices": [index for face in shape.faces for index in face],
    }
    return [("triangles", part | corners | {"colors": []})]


_PARTS: dict[str, Callable[[Shape], list[Part]]] = {
    "sphere": lambda shape: _round(shape, [shape.size[0]] * 3),
    "ellipsoid": lambda shape: _round(shape, shape.size),
    "box": _cube,
    "capsule": _capsule,
    "cylinder": _cylinder,
    "plane": _plane,
    "mesh": _mesh,
}
"""Foxglove's primitives for each kind of shape."""


def _contacts(recording: Recording) -> Iterator[Message]:
    """Yield the contact forces as arrows, 2 cm for each newton, as one entity that each frame replaces."""
    contacts = recording.contacts
    if contacts is None:
        return
    for frame, time in enumerate(recording.frame_time.tolist()):
        rows = contacts.at(frame)
        lines = {
            "type": 2,  # pairs of points
            "pose": {"position": _vector((0, 0, 0)), "orientation": _turn((1, 0, 0, 0))},
            "thickness": 0.003,
            "scale_invariant": False,
            "points": [
                _vector(point)
                for start, force in zip(contacts.position[rows], contacts.force[rows], strict=True)
                for point in (start, start + 0.02 * force)
            ],
            "color": {"r": 1.0, "g": 0.5, "b": 0.05, "a": 1.0},
            "colors": [],
            "indices": [],
        }
        entity = _entity(time, "contacts", ()) | {"frame_id": ROOT, "lines": [lines]}
        yield time, "/contacts", {"deletions": [], "entities": [entity]}
