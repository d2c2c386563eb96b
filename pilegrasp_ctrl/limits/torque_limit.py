"""Torques of joints and of the motors that share them, as rows on the accelerations that they produce."""

from __future__ import annotations

import numpy as np

from ..arm.model import ArmModel
from ..types import Array

_ROUND_OFF = 1e-12


class TorqueLimit:
    """`|S (M a + offset)| <= limit`, where `offset` is every torque beside that of the acceleration.

    S is the identity where each joint has its own motor. In a differential two motors share two joints, and what one
    joint may have depends on what the other takes: with motor speeds `joint_to_motor v`, power is the same on both
    sides where `tau = joint_to_motorᵀ tau_motor`, so that the rows of S are those of the inverse transpose. A joint
    that no motor shares keeps its own row and limit; the limits of joints that are shared follow from the motors'.

    Attributes:
        name: how `active_limits` calls it.
        matrix: (nv, nv) S, or None for the identity.
        limit: (nv,) largest torques of joints, and of motors that are shared [N·m].
        row_names: (nv,) such as "torque[0]" or "motor[1]".
    """

    name = "torque"

    def __init__(self, arm: ArmModel) -> None:
        """Take the arm's limits."""
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

    def rows(self, M: Array) -> Array:
        """Return S M (nv, nv) for the joint-space inertia M (nv, nv)."""
        return M if self.matrix is None else self.matrix.dot(M)

    def write(self, lower: Array, upper: Array, offset: Array) -> None:
        """Fill the bounds `lower` and `upper` (nv,) on S M a.

        Args:
            lower: where to.
            upper: where to.
            offset: (nv,) Coriolis, gravity and feed-forward torques [N·m].
        """
        if self.matrix is not None:
            offset = self.matrix.dot(offset)
        np.subtract(self._below, offset, out=lower)
        np.subtract(self.limit, offset, out=upper)

    def cut(self, torque: Array) -> Array:
        """Return the joint torques (nv,) nearest to `torque` in S that are within the limits [N·m]."""
        if self.matrix is None:
            return np.minimum(np.maximum(torque, -self.limit), self.limit)
        # S and its inverse round: what is cut stays that much below.
        limit = (1.0 - _ROUND_OFF) * self.limit
        return self._inverse.dot(np.minimum(np.maximum(self.matrix.dot(torque), -limit), limit))
