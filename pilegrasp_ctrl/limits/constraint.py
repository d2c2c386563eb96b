"""What a limit hands to the quadratic program."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..types import Array


class Constraint(NamedTuple):
    """Two-sided rows lower <= G a <= upper on the joint accelerations a; G = None stands for the identity."""

    G: Array | None
    lower: Array
    upper: Array


class AffineBounds(NamedTuple):
    """Bounds on the joint accelerations that are affine in the state x = [q; v].

    `lower_matrix x + lower_offset <= a <= upper_matrix x + upper_offset`, matrices (nv, 2 nv), offsets (nv,).
    """

    lower_matrix: Array
    lower_offset: Array
    upper_matrix: Array
    upper_offset: Array

    def at(self, q: Array, v: Array) -> Constraint:
        """Return the bounds at one state."""
        x = np.concatenate((q, v))
        return Constraint(None, self.lower_matrix @ x + self.lower_offset, self.upper_matrix @ x + self.upper_offset)
