"""The drawn bodies of an attempt whose hand is exchanged: those of both scenes.

A body that is not in the present scene stands where the arm's first link is, which hides it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..recording_parts import Body
from ..types import Array

UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])
"""(4,) quaternion wxyz of a body that is not in the scene."""


class BodyUnion:
    """Bodies of one or two scenes.

    Attributes:
        bodies: All bodies; those of the first scene come first.
        indices: (b,) index in `bodies` of each body of the present scene.
    """

    def __init__(self, bodies: Sequence[Body], indices: NDArray[np.int32] | None = None) -> None:
        """Take all bodies, and those of the present scene; all of them if absent."""
        self.bodies = tuple(bodies)
        self.indices = np.arange(len(self.bodies), dtype=np.int32) if indices is None else indices

    def joined(self, bodies: Sequence[Body]) -> BodyUnion:
        """Return the union with the bodies of the next scene; equal bodies are one, others get a name of their own."""
        known = list(self.bodies)
        indices = []
        for body in bodies:
            if body not in known:
                names = {each.name for each in known}
                known.append(replace(body, name=f"{body.name}_2") if body.name in names else body)
                indices.append(len(known) - 1)
            else:
                indices.append(known.index(body))
        return BodyUnion(known, np.array(indices, dtype=np.int32))

    def place(self, positions: Array, quaternions: Array) -> tuple[Array, Array]:
        """Return positions (B, 3) and quaternions (B, 4) of all bodies, from those of the present scene."""
        present = np.zeros(len(self.bodies), dtype=int)
        present[self.indices] = np.arange(len(self.indices))
        first = int(np.flatnonzero(self.indices == self._first_link())[0])
        all_positions, all_quaternions = positions[present], quaternions[present]
        absent = np.setdiff1d(np.arange(len(self.bodies)), self.indices)
        all_positions[absent], all_quaternions[absent] = positions[first], UPRIGHT
        return all_positions, all_quaternions

    def completed(self, positions: Array, quaternions: Array) -> tuple[Array, Array]:
        """Return poses of all bodies from those of the first ones, which an earlier union had."""
        missing = len(self.bodies) - len(positions)
        hidden = np.tile(positions[self._first_link()], (missing, 1)), np.tile(UPRIGHT, (missing, 1))
        return np.vstack([positions, hidden[0]]), np.vstack([quaternions, hidden[1]])

    def _first_link(self) -> int:
        """Return the index of the arm's first link; 0 if no arm is drawn."""
        return next((index for index, body in enumerate(self.bodies) if body.role == "arm"), 0)
