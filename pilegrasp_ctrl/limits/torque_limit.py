"""Limits on the torques of joints, and of motors that share joints, and on the rate at which torques change."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..arm.fitting import check_arm, check_rate
from ..arm.model import ArmModel
from ..arm.state import ArmState
from ..exceptions import ConfigurationError
from ..kernels.algebra import invert, multiply, product
from ..kernels.friction import clip
from ..kernels.program import torque_bounds
from ..types import Array
from .limit import Bounds

_ROUND_OFF = 1e-12
"""Relative amount by which a torque is cut below its limit, because S and its inverse round; chosen."""


class TorqueLimit:
    """The limit `|S (M a + h)| <= limit`; the state's h holds every torque except that of the acceleration.

    S is the identity if each joint has its own motor. In a differential two motors share two joints, and the torque
    left for one joint depends on the other's. With motor speeds `joint_to_motor v`, power is the same on both sides if
    `tau = joint_to_motorᵀ tau_motor`. The rows of S are therefore those of the inverse transpose. A joint with its own
    motor keeps its row and its limit; the limits of shared joints follow from those of the motors.

    Attributes:
        arm: Arm whose torques they are.
        S: (nv, nv) Matrix S.
        matrix: (nv, nv) Matrix S; None for the identity.
        limit: (nv,) Largest torques of joints, and of shared motors [N·m].
        row_names: (nv,) Names in `active_limits`, such as "torque[0]" or "motor[1]".
    """

    hard = True
    on_torque = True

    def __init__(self, arm: ArmModel) -> None:
        """Take the limits of the arm.

        Raises:
            ArgumentError: `arm` is not an arm.
        """
        check_arm(arm, "TorqueLimit")
        self.arm = arm
        self.matrix: Array | None = None
        self.limit = arm.torque_limit
        names = [f"torque[{joint}]" for joint in range(arm.nv)]
        if arm.joint_to_motor is not None and arm.motor_torque_limit is not None:
            names = self._couple(arm.joint_to_motor, arm.motor_torque_limit, names)
        self.row_names = tuple(names)
        self.S = np.eye(arm.nv) if self.matrix is None else np.ascontiguousarray(self.matrix)

    def _couple(self, joint_to_motor: Array, motor_limit: Array, names: list[str]) -> list[str]:
        links = joint_to_motor != 0.0
        shared = (links.sum(axis=1) > 1) | (links & (links.sum(axis=0) > 1)).any(axis=1)
        if not shared.any():
            return names
        joint = links.argmax(axis=1)
        unit = np.eye(len(joint))[joint]
        self.matrix = np.where(shared[:, None], _inverse(joint_to_motor).T, unit)
        self._inverse = _inverse(self.matrix)
        self.limit = np.where(shared, motor_limit, self.limit[joint])
        return [f"motor[{row}]" if shared[row] else f"torque[{joint[row]}]" for row in range(len(joint))]

    def __repr__(self) -> str:
        return f"TorqueLimit({dict(zip(self.row_names, self.limit.tolist(), strict=True))})"

    def rows(self, state: ArmState) -> Bounds:
        """Return the rows S M with their bounds [N·m]."""
        n = len(self.limit)
        lower, upper = np.empty(n), np.empty(n)
        torque_bounds(self.S, self.limit, state.h, lower, upper)
        G = state.M
        if self.matrix is not None:
            G = np.empty((n, n))
            product(self.S, state.M, G)
        return Bounds(G, lower, upper, self.row_names)

    def cut(self, torque: Array, state: ArmState | None = None) -> Array:
        """Return the joint torques (nv,) within the limits that are nearest to `torque` in the axes of S [N·m]."""
        if self.matrix is None:
            cut = np.empty(len(torque))
            clip(torque, self.limit, cut)
            return cut
        limit = (1.0 - _ROUND_OFF) * self.limit
        shared, cut = np.empty(len(limit)), np.empty(len(limit))
        multiply(self.S, torque, shared)
        multiply(self._inverse, np.minimum(np.maximum(shared, -limit), limit), cut)
        return cut


def _inverse(matrix: Array) -> Array:
    inverse = np.empty(matrix.shape)
    invert(matrix, inverse)
    return inverse


class TorqueRateLimit:
    """Keeps the change of each joint's torque from period to period within `rate_limit`.

    A reference that jumps then moves the torques as fast as the drives allow, and no faster. The limit is hard. Where
    it leaves too little room for the soft limits of speed and position, these give way.

    Attributes:
        arm: Arm whose torques they are.
        rate_limit: (nv,) Largest rate [N·m/s].
        rate: Control rate [Hz].
    """

    hard = True
    on_torque = True

    def __init__(self, arm: ArmModel, rate_limit: ArrayLike, rate: float = 500.0) -> None:
        """Set the limit.

        Args:
            arm: Arm whose torques they are.
            rate_limit: Scalar or (nv,) largest rate [N·m/s]; 1 N·m/ms is 1000.
            rate: Control rate [Hz].

        Raises:
            ConfigurationError: A rate is not positive and finite, or does not fit the arm.
        """
        check_arm(arm, "TorqueRateLimit")
        self.arm = arm
        self.rate_limit = joint_values(arm, rate_limit, "rate_limit")
        self.rate = check_rate(rate)
        self._step = self.rate_limit / rate
        self.row_names = tuple(f"torque rate[{joint}]" for joint in range(arm.nv))

    def __repr__(self) -> str:
        return f"TorqueRateLimit({self.rate_limit.tolist()}, rate={self.rate:g})"

    def rows(self, state: ArmState) -> Bounds:
        """Return the rows M with their bounds [N·m]; no bounds in the first period, which has no last torque."""
        if state.torque is None:
            free = np.full(len(self._step), np.inf)
            return Bounds(state.M, -free, free, self.row_names)
        rest = state.torque - state.h
        return Bounds(state.M, rest - self._step, rest + self._step, self.row_names)

    def cut(self, torque: Array, state: ArmState) -> Array:
        """Return the joint torques (nv,) within the limit that are nearest to `torque` [N·m]."""
        if state.torque is None:
            return torque
        return np.minimum(np.maximum(torque, state.torque - self._step), state.torque + self._step)


def joint_values(arm: ArmModel, value: ArrayLike, name: str) -> Array:
    """Return (nv,) positive, finite values from one number or one for each joint.

    Raises:
        ConfigurationError: The value has another form.
    """
    try:
        array = np.array(np.broadcast_to(np.asarray(value, dtype=np.float64), (arm.nv,)))
    except (TypeError, ValueError):
        array = np.zeros(1)
    if not ((array > 0.0) & (array < np.inf)).all():
        joints = ", ".join(arm.joint_names)
        raise ConfigurationError(f"{name} = {value!r:.80} must be one positive number, or one for each of {joints}")
    array.setflags(write=False)
    return array
