"""The contact forces of a recording as one block of bytes that the page's script reads."""

from __future__ import annotations

import struct

import numpy as np

from pilegrasp_ctrl.recording import Recording

METER, NEWTON = 1e-4, 1e-2
"""Units of the block's whole numbers; 16 bits hold 3.2 m and 327 N."""

_LARGEST = 32767


def contact_block(recording: Recording) -> bytes:
    """Return the contacts, or nothing where none were recorded.

    The block holds F as uint32; the number of contacts of each frame as uint16; then for all contacts the position
    [0.1 mm], three int16 each, the force on the first body [0.01 N], three int16 each, and one byte: 0 where the first
    body belongs to the arm or the hand, 1 where it is an object on a support, 2 between two objects. All numbers are
    little-endian. Contacts beyond 3.2 m are left out and forces cut at 327 N.
    """
    contacts = recording.contacts
    if contacts is None:
        return b""
    near = (np.abs(contacts.position) < METER * _LARGEST).all(axis=1)
    frame = np.repeat(np.arange(contacts.frames), np.diff(contacts.start))
    count = np.bincount(frame[near], minlength=contacts.frames).clip(0, 65535)
    movable = np.array([body.role == "object" for body in recording.bodies])
    own = np.array([body.role in ("arm", "hand", "sensor") for body in recording.bodies])
    first, second = contacts.bodies[near].T
    kind = np.where(own[first], 0, np.where(movable[first] & movable[second], 2, 1))
    force = np.clip(contacts.force[near].astype(np.float64) / NEWTON, -_LARGEST, _LARGEST)
    return b"".join(
        (
            struct.pack("<I", contacts.frames),
            count.astype("<u2").tobytes(),
            np.round(contacts.position[near] / METER).astype("<i2").tobytes(),
            np.round(force).astype("<i2").tobytes(),
            kind.astype("u1").tobytes(),
        )
    )
