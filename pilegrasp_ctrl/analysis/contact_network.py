"""Measures of the recorded contacts: the objects that the hand touches, and the force chains through the pile."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..recording import Recording
from .push_motion import PushMotion


def objects_touching_hand(recording: Recording, push: PushMotion) -> NDArray[np.bool_]:
    """Return which objects touch the hand (F, n) in the frames of `push`; none if no contacts were recorded."""
    touched = np.zeros(push.relative.shape[:2], dtype=bool)
    contacts = recording.contacts
    if contacts is None:
        return touched
    first = int(np.searchsorted(recording.frame_time, push.time[0]))
    start = contacts.start[first : first + push.time.size + 1]
    frame = np.repeat(np.arange(push.time.size), np.diff(start))
    rows = slice(int(start[0]), int(start[-1]))
    hand = np.array([body.role == "hand" for body in recording.bodies])
    columns = {name: column for column, name in enumerate(push.objects)}
    column = np.array([columns.get(body.name, -1) for body in recording.bodies])
    for side in (0, 1):
        body, other = contacts.bodies[rows, side], contacts.bodies[rows, 1 - side]
        chosen = hand[other] & (column[body] >= 0)
        touched[frame[chosen], column[body[chosen]]] = True
    return touched


def force_chains(recording: Recording, push: PushMotion) -> dict[str, Any] | None:
    """Return the chains of strong contacts that start at the hand, or None if no contacts were recorded.

    A contact between objects is strong if it presses more than the mean over all contacts between objects in the same
    frame. Strong contacts carry the load of a granular material (Radjai et al., Phys. Rev. Lett. 80, 61, 1998). A chain
    starts at an object that the hand touches and continues over strong contacts to other objects.

    Keys:
        objects: Mean number of objects in the chains, over the frames of the push in which the hand touches one.
        to_support: Share of those frames in which a chain ends at a wall.
        at_end: Names of the objects in the chains in the last of those frames.
    """
    contacts = recording.contacts
    if contacts is None:
        return None
    roles = np.array([body.role for body in recording.bodies])
    first = int(np.searchsorted(recording.frame_time, push.time[0]))
    sizes, reached, last = [], [], set[int]()
    for frame in range(first, first + push.time.size):
        rows = contacts.at(frame)
        bodies, force = contacts.bodies[rows], contacts.force[rows].astype(float)
        chain = _chain(bodies, roles[bodies], np.linalg.norm(force, axis=1))
        if chain:
            sizes.append(len(chain))
            reached.append(bool(chain & _against_walls(bodies, roles[bodies], force)))
            last = chain
    return {
        "objects": float(np.mean(sizes)) if sizes else None,
        "to_support": float(np.mean(reached)) if reached else None,
        "at_end": [recording.bodies[index].name for index in sorted(last)],
    }


def _chain(bodies: np.ndarray, roles: np.ndarray, strength: np.ndarray) -> set[int]:
    """Return the objects that strong contacts connect with the hand."""
    between = (roles == "object").all(axis=1)
    strong = between & (strength > strength[between].mean()) if between.any() else between
    neighbours: dict[int, set[int]] = {}
    for a, b in bodies[strong].tolist():
        neighbours.setdefault(a, set()).add(b)
        neighbours.setdefault(b, set()).add(a)
    at_hand = (roles == "hand").any(axis=1) & (roles == "object").any(axis=1)
    waiting = set(bodies[at_hand][roles[at_hand] == "object"].tolist())
    chain: set[int] = set()
    while waiting:
        found = waiting.pop()
        chain.add(found)
        waiting |= neighbours.get(found, set()) - chain
    return chain


def _against_walls(bodies: np.ndarray, roles: np.ndarray, force: np.ndarray) -> set[int]:
    """Return the objects that a support pushes more sideways than up; the table and the walls may be one body."""
    across = np.hypot(force[:, 0], force[:, 1]) > np.abs(force[:, 2])
    at_wall = (roles == "support").any(axis=1) & (roles == "object").any(axis=1) & across
    return set(bodies[at_wall][roles[at_wall] == "object"].tolist())
