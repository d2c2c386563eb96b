"""A recording as a file of Rerun (rerun.io): bodies, wrench, contacts, signals and events on one clock."""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pilegrasp_ctrl.analysis.reading import plain, text
from pilegrasp_ctrl.exceptions import ExportError
from pilegrasp_ctrl.files import write_output
from pilegrasp_ctrl.recording import Recording, Shape
from pilegrasp_ctrl.viewer.page.summary import primitive_rows
from pilegrasp_ctrl.viewer.scene.shapes import ENDLESS_PLANE

TIMELINE = "time"
"""Name of the timeline, in seconds of simulated time."""


def require_rerun() -> None:
    """Check that Rerun's library is installed.

    Raises:
        ExportError: It is not.
    """
    if importlib.util.find_spec("rerun") is None:
        raise ExportError("an .rrd file needs Rerun's library; install it with `pip install 'pilegrasp[export]'`")


def write_rrd(recording: Recording, path: str | os.PathLike[str]) -> None:
    """Write the recording for Rerun's viewer, all of it or nothing.

    Bodies are entities under `scene/ROLE/NAME`, signals scalars under `signals/NAME`, the end of each primitive a line
    of text under `events`. Rerun stamps its own identities into the file, so equal recordings give unequal bytes.

    Raises:
        ExportError: Rerun's library is missing, or the path cannot be written.
    """
    require_rerun()
    import rerun

    stream = rerun.RecordingStream("pilegrasp", recording_id=_identity(recording))
    # The bytes are complete before the file is made.
    sink = rerun.binary_stream(stream)
    stream.log("scene", rerun.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    _log_bodies(rerun, stream, recording)
    _log_contacts(rerun, stream, recording)
    _log_signals(rerun, stream, recording)
    for row in primitive_rows(recording.meta.get("outcomes")):
        stream.set_time(TIMELINE, duration=row.end)
        level = "WARN" if row.failed else "INFO"
        stream.log("events", rerun.TextLog(f"{plain(row.name)}: {plain(row.trigger)}", level=level))
    content = sink.read(flush=True)
    write_output(Path(path), content or b"", "recording")


def _identity(recording: Recording) -> str:
    meta = recording.meta
    return f"{text(meta.get('scenario'), 60) or 'recording'} {text(meta.get('seed'), 20)}".strip()


def _log_bodies(rerun: Any, stream: Any, recording: Recording) -> None:
    times = [rerun.TimeColumn(TIMELINE, duration=recording.frame_time)]
    for index, body in enumerate(recording.bodies):
        entity = ["scene", body.role, f"{index} {body.name}"]
        for number_, shape in enumerate(body.shapes):
            position = rerun.Transform3D(translation=shape.position, quaternion=_xyzw(shape.quaternion))
            stream.log([*entity, str(number_)], position, _archetype(rerun, shape), static=True)
        poses = rerun.Transform3D.columns(
            translation=recording.body_position[:, index], quaternion=_xyzw(recording.body_quaternion[:, index])
        )
        stream.send_columns("/".join(map(_escaped, entity)), indexes=times, columns=poses)


def _xyzw(quaternion: Any) -> np.ndarray:
    return np.roll(np.asarray(quaternion), -1, axis=-1)


def _escaped(part: str) -> str:
    """Return a part of an entity's path, in which Rerun wants every sign but letters and digits marked."""
    return "".join(letter if letter.isalnum() or letter in "-_." else f"\\{letter}" for letter in part)


def _archetype(rerun: Any, shape: Shape) -> Any:
    colour = [round(255 * part) for part in shape.rgba]
    if shape.kind == "mesh":
        return rerun.Mesh3D(vertex_positions=shape.vertices, triangle_indices=shape.faces, albedo_factor=colour)
    return _ARCHETYPES[shape.kind](rerun, shape.size, {"colors": [colour]})


def _plane(rerun: Any, size: Sequence[float], style: dict[str, Any]) -> Any:
    return rerun.Boxes3D(
        half_sizes=[[size[0] or ENDLESS_PLANE, size[1] or ENDLESS_PLANE, 0.0005]], fill_mode="solid", **style
    )


_ARCHETYPES: dict[str, Callable[[Any, Sequence[float], dict[str, Any]], Any]] = {
    "sphere": lambda rr, size, style: rr.Ellipsoids3D(half_sizes=[[size[0]] * 3], fill_mode="solid", **style),
    "ellipsoid": lambda rr, size, style: rr.Ellipsoids3D(half_sizes=[size], fill_mode="solid", **style),
    "box": lambda rr, size, style: rr.Boxes3D(half_sizes=[size], fill_mode="solid", **style),
    "capsule": lambda rr, size, style: rr.Capsules3D(
        lengths=[2.0 * size[1]], radii=[size[0]], translations=[[0.0, 0.0, -size[1]]], fill_mode="solid", **style
    ),
    "cylinder": lambda rr, size, style: rr.Cylinders3D(
        lengths=[2.0 * size[1]], radii=[size[0]], fill_mode="solid", **style
    ),
    "plane": _plane,
}
"""Rerun's archetype for each kind of primitive."""


def _log_contacts(rerun: Any, stream: Any, recording: Recording) -> None:
    contacts = recording.contacts
    if contacts is None or not len(contacts.force):
        return
    arrows = rerun.Arrows3D.columns(origins=contacts.position, vectors=0.02 * contacts.force)  # 2 cm for each newton
    stream.send_columns(
        "scene/contacts",
        indexes=[rerun.TimeColumn(TIMELINE, duration=recording.frame_time)],
        columns=arrows.partition(np.diff(contacts.start)),
    )


def _log_signals(rerun: Any, stream: Any, recording: Recording) -> None:
    times = [rerun.TimeColumn(TIMELINE, duration=recording.signal_time)]
    for name, values in recording.signals.items():
        width = 1 if values.ndim == 1 else values.shape[1]
        columns = rerun.Scalars.columns(scalars=np.asarray(values, dtype=float).reshape(-1, width))
        stream.send_columns(f"signals/{_escaped(name)}", indexes=times, columns=columns)
