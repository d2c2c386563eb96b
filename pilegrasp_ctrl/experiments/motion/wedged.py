"""Which objects are caught between the hand and a wall, from the recorded contacts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...recording import Recording
from .push_motion import PushMotion


def wedged(recording: Recording, push: PushMotion) -> NDArray[np.bool_]:
    """Return which objects the hand pushes against a support with its middle: (F, n), frames and objects of `push`.

    An object is wedged where it touches the hand, a support stops it, and the hand's middle line passes through it; one
    farther aside rolls off along the hand. A support stops what it presses against the push, and more across than up:
    table and walls may be one body, and the table's friction is against the push as well. Nothing is wedged where no
    contacts were recorded.
    """
    at_hand = np.zeros(push.relative.shape[:2], dtype=bool)
    stopped = np.zeros_like(at_hand)
    contacts = recording.contacts
    if contacts is None:
        return stopped
    first = int(np.searchsorted(recording.frame_time, push.time[0]))
    start = contacts.start[first : first + push.time.size + 1]
    frame = np.repeat(np.arange(push.time.size), np.diff(start))
    rows = slice(int(start[0]), int(start[-1]))
    roles = np.array([body.role for body in recording.bodies])
    column = np.array([push.objects.index(body.name) if body.name in push.objects else -1 for body in recording.bodies])
    for one, sign in ((0, 1.0), (1, -1.0)):
        own, other = column[contacts.bodies[rows, one]], roles[contacts.bodies[rows, 1 - one]]
        force = sign * contacts.force[rows].astype(float)
        across = np.hypot(force[:, 0], force[:, 1]) > np.abs(force[:, 2])
        held_back = (other == "support") & across & (force @ push.axes[0] < 0.0)
        for flags, where in ((at_hand, other == "hand"), (stopped, held_back)):
            chosen = where & (own >= 0)
            flags[frame[chosen], own[chosen]] = True
    return at_hand & stopped & (np.abs(push.relative[..., 1]) <= push.radius)
