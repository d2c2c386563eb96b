"""Which objects the hand touches, from the recorded contacts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..recording import Recording
from .push_motion import PushMotion


def touching(recording: Recording, push: PushMotion) -> NDArray[np.bool_]:
    """Return which objects touch the hand: (F, n), frames and objects of `push`.

    None does where no contacts were recorded.
    """
    touched = np.zeros(push.relative.shape[:2], dtype=bool)
    contacts = recording.contacts
    if contacts is None:
        return touched
    first = int(np.searchsorted(recording.frame_time, push.time[0]))
    start = contacts.start[first : first + push.time.size + 1]
    frame = np.repeat(np.arange(push.time.size), np.diff(start))
    rows = slice(int(start[0]), int(start[-1]))
    hand = np.array([body.role == "hand" for body in recording.bodies])
    column = np.array([push.objects.index(body.name) if body.name in push.objects else -1 for body in recording.bodies])
    for one in (0, 1):
        own, other = contacts.bodies[rows, one], contacts.bodies[rows, 1 - one]
        chosen = hand[other] & (column[own] >= 0)
        touched[frame[chosen], column[own[chosen]]] = True
    return touched
