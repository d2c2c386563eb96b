"""Joint torques, as rows on the accelerations that they produce."""

from __future__ import annotations

import numpy as np

from ..arm_model import ArmModel
from ..arm_state import ArmState
from ..types import Array
from .constraint import Constraint


class TorqueLimit:
    """|M a + offset| <= torque limit, where `offset` is every torque beside that of the acceleration.

    Attributes:
        name: how `active_limits` calls it.
        torque: (nv,) largest torques [N·m].
    """

    name = "torque"

    def __init__(self, arm: ArmModel) -> None:
        """Take the arm's limits."""
        self.torque = arm.torque_limit
        self._range = np.stack((-arm.torque_limit, arm.torque_limit))

    def write(self, bounds: Array, offset: Array) -> None:
        """Fill `bounds` (2, nv), below and above, on M a.

        Args:
            bounds: where to.
            offset: (nv,) Coriolis, gravity and feed-forward torques [N·m].
        """
        np.subtract(self._range, offset, out=bounds)

    def constraint(self, state: ArmState) -> Constraint:
        """Return the rows at one state, without feed-forward."""
        return Constraint(state.M, -self.torque - state.h, self.torque - state.h)
