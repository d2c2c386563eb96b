"""The cost that a task adds."""

from __future__ import annotations

from typing import NamedTuple

from ..types import Array


class Objective(NamedTuple):
    """The cost |A a + c|² of the joint accelerations a; a task's weight enters its rows as a square root.

    Rows rather than H = Aᵀ A: all tasks then share one product, and a weight stays visible.

    Attributes:
        A: (m, nv) rows.
        c: (m,) what the rows are at a = 0.
    """

    A: Array
    c: Array
