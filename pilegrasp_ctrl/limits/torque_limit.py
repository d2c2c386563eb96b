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

    def write(self, constraint: Constraint, offset: Array) -> None:
        """Fill the bounds of the rows G = M for `offset` (nv,), Coriolis, gravity and feed-forward torques [N·m]."""
        np.subtract(self.torque, offset, out=constraint.upper)
        np.add(self.torque, offset, out=constraint.lower)
        np.negative(constraint.lower, out=constraint.lower)

    def constraint(self, state: ArmState) -> Constraint:
        """Return the rows at one state, without feed-forward."""
        return Constraint(state.M, -self.torque - state.h, self.torque - state.h)
