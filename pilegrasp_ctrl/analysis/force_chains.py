"""Force chains: how the hand's push runs through the pile, from the recorded contact forces."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..recording import Recording
from .push_motion import PushMotion


def force_chains(recording: Recording, push: PushMotion) -> dict[str, Any] | None:
    """Return the chains of strong contacts that start at the hand, or None where no contacts were recorded.

    A contact between objects is strong where it presses more than the mean over all contacts between objects of the
    same frame: those carry a granular material's load (Radjai et al., Phys. Rev. Lett. 80, 61, 1998). A chain leads
    from an object that the hand touches over strong contacts to others.

    Keys:
        objects: mean number of objects in the chains, over the frames of the push in which the hand touches one.
        to_support: share of those frames in which a chain ends at a wall.
        at_end: names of the objects in the chains in the last of those frames.
    """
    contacts = getattr(recording, "contacts", None)
    if contacts is None:
        return None
    roles = np.array([body.role for body in recording.bodies])
    first = int(np.searchsorted(recording.frame_time, push.time[0]))
    sizes, reached, last = [], [], set[int]()
    for frame in range(first, first + push.time.size):
        rows = slice(int(contacts.start[frame]), int(contacts.start[frame + 1]))
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
    """Return the objects that a support pushes more across than up; the table and the walls may be one body."""
    across = np.hypot(force[:, 0], force[:, 1]) > np.abs(force[:, 2])
    at_wall = (roles == "support").any(axis=1) & (roles == "object").any(axis=1) & across
    return set(bodies[at_wall][roles[at_wall] == "object"].tolist())
