"""Limit on the accelerations of the joints."""

from __future__ import annotations

from numpy.typing import ArrayLike

from ..arm.fitting import check_arm
from ..arm.model import ArmModel
from ..arm.state import ArmState
from .limit import Bounds
from .torque_limit import joint_values


class AccelerationLimit:
    """Keeps |a| of each joint within a largest acceleration.

    It is soft: a joint that has to brake before the end of its range may exceed it.

    Attributes:
        arm: Arm whose joints they are.
        limit: (nv,) Largest accelerations [rad/s²].
    """

    hard = False

    def __init__(self, arm: ArmModel, limit: ArrayLike) -> None:
        """Set the limit.

        Args:
            arm: Arm whose joints they are.
            limit: Scalar or (nv,) largest acceleration [rad/s²].

        Raises:
            ConfigurationError: A value is not positive and finite, or does not fit the arm.
        """
        check_arm(arm, "AccelerationLimit")
        self.arm = arm
        self.limit = joint_values(arm, limit, "limit")
        self._names = tuple(f"acceleration[{joint}]" for joint in range(arm.nv))

    def __repr__(self) -> str:
        return f"AccelerationLimit({self.limit.tolist()})"

    def rows(self, state: ArmState) -> Bounds:
        """Return the bounds on the joint accelerations [rad/s²]."""
        return Bounds(None, -self.limit, self.limit, self._names)
