"""The program as qpsolvers states it."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..types import Array
from .program import QuadraticProgram

if TYPE_CHECKING:
    import qpsolvers


class RowKinds(NamedTuple):
    """The rows of a program by the form in which qpsolvers takes them, each kind as indices among the n + m rows.

    Attributes:
        equal: Rows with equal bounds; they become equations.
        above: Other rows of G x with an upper bound; they become inequalities.
        below: Other rows of G x with a lower bound; they become inequalities with the other sign.
    """

    equal: NDArray[np.intp]
    above: NDArray[np.intp]
    below: NDArray[np.intp]

    @classmethod
    def of(cls, program: QuadraticProgram) -> RowKinds:
        """Sort the rows of a program."""
        lower, upper = program.lower, program.upper
        equal = lower == upper
        general = ~equal & (np.arange(len(lower)) >= len(program.f))
        return cls(*map(np.flatnonzero, (equal, general & (upper < np.inf), general & (lower > -np.inf))))


def as_problem(program: QuadraticProgram) -> qpsolvers.Problem:
    """Return the program as `qpsolvers.Problem`, with dense matrices.

    qpsolvers minimises `½ xᵀ P x + qᵀ x` with `G x <= h`, `A x = b` and `lb <= x <= ub`. A row of G x with two finite
    bounds becomes two rows there, upper bounds first. A row of x or of G x with equal bounds becomes an equation. What
    is not needed is None.
    """
    import qpsolvers

    H, f, G, lower, upper = program
    n, kinds = len(f), RowKinds.of(program)
    rows = np.vstack((np.eye(n), G))
    one_sided = np.vstack((rows[kinds.above], -rows[kinds.below]))
    h = np.concatenate((upper[kinds.above], -lower[kinds.below]))
    free = lower[:n] == upper[:n]
    return qpsolvers.Problem(
        H.copy(),
        f.copy(),
        *((one_sided, h) if len(h) else (None, None)),
        *((rows[kinds.equal], lower[kinds.equal]) if len(kinds.equal) else (None, None)),
        _box(np.where(free, -np.inf, lower[:n])),
        _box(np.where(free, np.inf, upper[:n])),
    )


def _box(bounds: Array) -> Array | None:
    """Return the bounds, or None if there is none."""
    return bounds if np.isfinite(bounds).any() else None
