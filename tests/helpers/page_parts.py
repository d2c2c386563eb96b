"""Bodies at rest, and readers of a stream of commands."""

from __future__ import annotations

import re

import numpy as np

from pilegrasp_ctrl.recording import Body, Recording


def still(shapes, position=(0.0, 0.0, 0.0), role="object", frames=2, **changes):
    """Return a recording of one body at rest."""
    arguments = {
        "meta": {},
        "bodies": (Body("thing", role, tuple(shapes)),),
        "frame_time": np.arange(frames) / 30.0,
        "body_position": np.broadcast_to(position, (frames, 1, 3)),
        "body_quaternion": np.broadcast_to((1.0, 0.0, 0.0, 0.0), (frames, 1, 4)),
        "signal_time": [],
        "signals": {},
    }
    return Recording(**(arguments | changes))


def floats(extension, width):
    return np.frombuffer(extension.data, dtype="<f4").reshape(-1, width).astype(np.float64)


def tracks(stream):
    """Return the animation's tracks: times and values by path and property."""
    (animation,) = [command for command in stream if command["type"] == "set_animation"]
    widths = {"quaternion": 4}
    return {
        entry["path"]: {
            track["name"]: (floats(track["times"], 1)[:, 0], floats(track["values"], widths.get(track["type"], 3)))
            for track in entry["clip"]["tracks"]
        }
        for entry in animation["animations"]
    }


def of_type(stream, name, path=""):
    return [command for command in stream if command["type"] == name and command["path"].startswith(path)]


def text_of(document):
    visible = re.sub(r"<(script|style)\b.*?</\1>", "", document, flags=re.DOTALL)
    return " ".join(re.sub(r"<[^>]+>", " ", visible).split())
