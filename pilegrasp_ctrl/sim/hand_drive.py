"""The drive of a hand: from a closure in [0, 1] to the controls of the hand's actuators."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..types import Array


@dataclass(frozen=True, slots=True, eq=False)
class HandDrive:
    """How a closure moves the actuators of a hand.

    Attributes:
        opened: (k,) controls of the open hand.
        closed: (k,) controls of the closed hand.
        stroke_time: Least time from open to closed [s]; 0 if the actuators take the closure as it comes.
    """

    opened: Array
    closed: Array
    stroke_time: float = 0.0

    def command(self, closure: float) -> Array:
        """Return the controls (k,) at a closure in [0, 1]."""
        return np.asarray(self.opened + (self.closed - self.opened) * closure)

    def next_closure(self, closure: float, wanted: float, period: float) -> float:
        """Return the closure after `period` [s] on the way from `closure` to the wanted one."""
        if self.stroke_time <= 0.0:
            return wanted
        step = period / self.stroke_time
        return min(max(wanted, closure - step), closure + step)
