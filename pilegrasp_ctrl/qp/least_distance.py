"""The quadratic program as a least-distance program, and its exact optimum from a guess of the active bounds."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels.algebra import multiply_transposed
from ..kernels.least_distance import invert_factor, transform
from ..kernels.working_set import nearest_point
from ..types import Array
from .program import QuadraticProgram

_MIN_MULTIPLIER = 1e-9
"""Multiplier relative to the largest, below which its bound is taken as inactive; chosen."""


class LeastDistanceProgram(NamedTuple):
    """The y nearest to `goal` with `lower <= rows y <= upper`, where x = L⁻ᵀ y and L Lᵀ = H.

    Splitting and proximal methods converge slowly if the cost's curvature differs between directions, here by the ratio
    of tool to posture weight. Their answers are as inexact as their tolerances, but their multipliers show, at least
    nearly, which bounds are active. A dual active-set method continues from this guess: it drops the bounds that pull,
    then adds the most exceeded one until none is exceeded. The right guess needs no step at all. The answer is in
    closed form for the final active set, so it does not depend on the guess.

    Attributes:
        goal: (n,) Minimum without bounds.
        rows: (k, n) Rows of unit length, one for each row of x and of G x that is bounded and not zero.
        lower: (k,) Lower bounds; -inf where there is none.
        upper: (k,) Upper bounds; inf where there is none.
        inverse: (n, n) Inverse L⁻¹.
        place: (k,) Indices of the rows among the n + m of the program.
        length: (k,) Lengths of the rows before they were scaled.
    """

    goal: Array
    rows: Array
    lower: Array
    upper: Array
    inverse: Array
    place: NDArray[np.intp]
    length: Array

    @classmethod
    def from_program(cls, program: QuadraticProgram) -> LeastDistanceProgram | None:
        """Return the program in y; None if it is not finite, H is not positive definite, or a row is infeasible."""
        H, f, G, lower, upper = program
        if not all(np.isfinite(array).all() for array in (H, f, G)) or not (lower <= upper).all():
            return None
        n, k = len(f), len(lower)
        inverse, goal, rows, length = np.empty((n, n)), np.empty(n), np.empty((k, n)), np.empty(k)
        if not invert_factor(H, inverse):
            return None
        transform(f, G, inverse, goal, rows, length)
        empty = length == 0.0
        if (lower[empty] > 0.0).any() or (upper[empty] < 0.0).any():
            return None
        place = np.flatnonzero((np.isfinite(lower) | np.isfinite(upper)) & ~empty)
        length = length[place]
        scaled = rows[place] / length[:, None]
        return cls(goal, scaled, lower[place] / length, upper[place] / length, inverse, place, length)

    def x(self, y: Array) -> Array:
        """Return the program's own variables (n,) at y."""
        x = np.empty(len(y))
        multiply_transposed(self.inverse, y, x)
        return x

    def nearest(self, multipliers: Array) -> Array | None:
        """Return the optimal y (n,), or None if no y is within the bounds.

        Args:
            multipliers: (k,) Guessed multipliers, positive at active lower bounds and negative at active upper ones.
        """
        largest = np.abs(multipliers).max(initial=0.0)
        guess = np.where(np.abs(multipliers) > _MIN_MULTIPLIER * largest, multipliers, 0.0)
        y = np.empty(len(self.goal))
        return y if nearest_point(self.goal, self.rows, self.lower, self.upper, guess, y) >= 0 else None
