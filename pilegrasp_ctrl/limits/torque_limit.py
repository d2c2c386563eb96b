"""Limits on the torques of joints, and of motors that share joints, as rows on the accelerations."""

from __future__ import annotations

import numpy as np

from ..arm.model import ArmModel
from ..types import Array

_ROUND_OFF = 1e-12
"""Relative amount by which a torque is cut below its limit, because S and its inverse round; chosen."""


class TorqueLimit:
    """The limit `|S (M a + offset)| <= limit`; `offset` holds every torque except that of the acceleration.

    S is the identity if each joint has its own motor. In a differential two motors share two joints, and the torque
    left for one joint depends on the other's. With motor speeds `joint_to_motor v`, power is the same on both sides if
    `tau = joint_to_motorᵀ tau_motor`, so the rows of S are those of the inverse transpose. A joint with its own motor
    keeps its row and its limit; the limits of shared joints follow from those of the motors.

    Attributes:
        matrix: (nv, nv) Matrix S; None for the identity.
        limit: (nv,) Largest torques of joints, and of shared motors [N·m].
        row_names: (nv,) Names in `active_limits`, such as "torque[0]" or "motor[1]".
    """

    def __init__(self, arm: ArmModel) -> None:
        """Take the limits of the arm."""
        self.matrix: Array | None = None
        self.limit = arm.torque_limit
        self.row_names = [f"torque[{joint}]" for joint in range(arm.nv)]
        if arm.joint_to_motor is not None and arm.motor_torque_limit is not None:
            self._couple(arm.joint_to_motor, arm.motor_torque_limit)
        self._below = -self.limit

    def _couple(self, joint_to_motor: Array, motor_limit: Array) -> None:
        links = joint_to_motor != 0.0
        shared = (links.sum(axis=1) > 1) | (links & (links.sum(axis=0) > 1)).any(axis=1)
        if not shared.any():
            return
        joint = links.argmax(axis=1)
        unit = np.eye(len(joint))[joint]
        self.matrix = np.where(shared[:, None], np.linalg.inv(joint_to_motor).T, unit)
        self._inverse = np.linalg.inv(self.matrix)
        self.limit = np.where(shared, motor_limit, self.limit[joint])
        self.row_names = [f"motor[{row}]" if shared[row] else f"torque[{joint[row]}]" for row in range(len(joint))]

    def __repr__(self) -> str:
        return f"TorqueLimit({dict(zip(self.row_names, self.limit.tolist(), strict=True))})"

    def rows(self, M: Array) -> Array:
        """Return S M (nv, nv) for the joint-space inertia M (nv, nv)."""
        return M if self.matrix is None else self.matrix.dot(M)

    def write(self, lower: Array, upper: Array, offset: Array) -> None:
        """Fill the bounds `lower` and `upper` (nv,) on S M a.

        Args:
            lower: (nv,) Array for the lower bounds [N·m].
            upper: (nv,) Array for the upper bounds [N·m].
            offset: (nv,) Coriolis, gravity and feed-forward torques [N·m].
        """
        if self.matrix is not None:
            offset = self.matrix.dot(offset)
        np.subtract(self._below, offset, out=lower)
        np.subtract(self.limit, offset, out=upper)

    def cut(self, torque: Array) -> Array:
        """Return the joint torques (nv,) within the limits that are nearest to `torque` in the axes of S [N·m]."""
        if self.matrix is None:
            return np.minimum(np.maximum(torque, -self.limit), self.limit)
        limit = (1.0 - _ROUND_OFF) * self.limit
        return self._inverse.dot(np.minimum(np.maximum(self.matrix.dot(torque), -limit), limit))
