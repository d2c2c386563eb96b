"""How much a page shows: a browser does not open a much larger one, and its making takes a bounded time."""

from __future__ import annotations

from pilegrasp_ctrl.exceptions import ExportError
from pilegrasp_ctrl.recording import Recording

MAX_FRAMES = 50_000
"""Largest number of frames: 28 minutes at 30 Hz; chosen."""

MAX_BODIES = 2_000
"""Largest number of bodies; chosen, twenty times those of a full bin."""

MAX_SHAPES = 10_000
"""Largest number of shapes of all bodies; chosen."""

MAX_PRIMITIVES = 5_000
"""Largest number of outcomes: seven for each attempt; chosen."""

MAX_ATTEMPTS = 500
"""Largest number of attempts of an order; chosen. So many take more than an hour."""


def check_size(recording: Recording) -> None:
    """Check that a page can show the recording.

    Raises:
        ExportError: The recording holds too much of something; the sentence says of what.
    """
    meta, bodies = recording.meta, recording.bodies
    counts = (
        ("frames", recording.frame_time.size, MAX_FRAMES),
        ("bodies", len(bodies), MAX_BODIES),
        ("shapes", sum(len(body.shapes) for body in bodies), MAX_SHAPES),
        ("outcomes", _length(meta.get("outcomes")), MAX_PRIMITIVES),
        ("attempts", _length(meta.get("attempts")), MAX_ATTEMPTS),
    )
    for name, count, limit in counts:
        if count > limit:
            remedy = "record an attempt that is shorter" if name == "frames" else "record a part of it"
            raise ExportError(f"the recording holds {count} {name}, and a page shows {limit} at most; {remedy}")


def _length(rows: object) -> int:
    return len(rows) if isinstance(rows, list) else 0
