"""A synthetic order of three attempts: one delivers, one holds too many and drops them back, one holds nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.recording_parts import Contacts
from synthetic_recording import synthetic

PERIOD = 12.0
"""Time from the start of an attempt to the next [s]."""

ENDS = ("release", "drop_back", None)
"""Primitive that opens the hand at the end of each attempt."""


def synthetic_order(frames: int = 300) -> Recording:
    """Return the order; every attempt repeats the motion of the synthetic attempt, the last one without objects."""
    once = synthetic(frames=frames)
    empty = synthetic(success=False, frames=frames)
    held = [body.name in ("light_sphere_00", "light_sphere_01") for body in once.bodies]
    nothing = np.array(once.body_position)
    nothing[:, held] = empty.body_position[:1, held]
    position = np.concatenate([once.body_position, once.body_position, nothing])
    outcomes = []
    for attempt, end in enumerate(ENDS):
        shift = PERIOD * attempt
        outcomes += [{**row, "start": row["start"] + shift, "end": row["end"] + shift} for row in once.meta["outcomes"]]
        if end:
            outcomes.append(
                {"name": end, "status": "ended", "trigger": "opened", "start": shift + 10.0, "end": shift + 11.9}
            )
    contacts = once.contacts
    attempts = [
        {"goal": "wall", "held": 1, "delivered": 1, "reason": ""},
        {"goal": "corner_left", "held": 2, "delivered": 0, "reason": "2 held where 1 were missing: dropped back"},
        {"goal": "wall", "held": 0, "delivered": 0, "reason": "nothing was in the hand after the lift"},
    ]
    times = [{"start": PERIOD * k, "end": PERIOD * k + (11.9 if k < 2 else 10.0)} for k in range(3)]
    meta = dict(once.meta) | {
        "scenario": "bin_picking",
        "success": False,
        "grasped": 1,
        "reason": "1 of 2 delivered after 3 attempts",
        "outcomes": outcomes,
        "attempts": [row | time for row, time in zip(attempts, times, strict=True)],
    }
    meta["config"] = dict(meta["config"]) | {"order": {"count": 2, "max_attempts": 3}, "program": "order"}

    def repeated(time: np.ndarray) -> np.ndarray:
        return np.concatenate([time + PERIOD * k for k in range(3)])

    return replace(
        once,
        meta=meta,
        frame_time=repeated(once.frame_time),
        body_position=position,
        body_quaternion=np.tile(once.body_quaternion, (3, 1, 1)),
        signal_time=repeated(once.signal_time),
        signals={name: np.tile(signal, (3,) + (1,) * (signal.ndim - 1)) for name, signal in once.signals.items()},
        contacts=Contacts(
            np.concatenate([[0], np.cumsum(np.tile(np.diff(contacts.start), 3))]),
            *(np.tile(getattr(contacts, name), (3, 1)) for name in ("bodies", "position", "force")),
        ),
    )
