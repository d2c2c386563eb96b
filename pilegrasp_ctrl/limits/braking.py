"""How hard the joints of an arm can brake, over its postures."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from math import pow

import numpy as np

from ..arm.model import ArmModel
from ..exceptions import BrakingWarning, ConfigurationError
from ..kernels.joint_limits import spare_torque
from ..types import Array
from .torque_limit import TorqueLimit

BRAKING_SHARE = 0.5
"""Share of the torque left by gravity and friction that brakes; the rest is for coupling and load. Chosen."""
MIN_BRAKING = 0.2
"""Least braking acceleration, for joints that gravity leaves no torque to brake with [rad/s²]; chosen."""
_SAMPLES = 64
"""Number of postures at which an arm is looked at; chosen."""
_MAX_WEAK = 0.5
"""Share of the postures in which a joint may be too weak for gravity before its arm is refused; chosen."""


class WorstCase:
    """What holds for the joints of an arm in any posture; computed anew where the arm gets another payload.

    The arm is looked at in postures spread evenly between the position limits.

    Attributes:
        braking: (nv,) `braking_acceleration` of the joints [rad/s²].
        gravity: (nv,) Largest torque of gravity on the joints [N·m].
        weak: (nv,) Share of the postures in which gravity and friction take up the torque limit of a joint.
    """

    def __init__(self, arm: ArmModel, share: float = BRAKING_SHARE) -> None:
        """Look at an arm whose joints brake with a `share` of the torque that gravity and friction leave."""
        self._share = share
        self._look_at(arm)

    def _look_at(self, arm: ArmModel) -> None:
        spare, inertia, gravity = (np.array(rows) for rows in zip(*_samples(arm), strict=True))
        self._arm = arm
        self.braking: Array = np.maximum((self._share * spare / inertia).min(axis=0), MIN_BRAKING)
        self.gravity: Array = gravity.max(axis=0)
        self.weak: Array = (spare <= 0.0).mean(axis=0)

    def of(self, arm: ArmModel) -> WorstCase:
        """Return this, for the arm of a state."""
        if arm is not self._arm:
            self._look_at(arm)
        return self

    def check(self) -> None:
        """Name a joint that cannot brake because its torque limit does not hold it against gravity.

        A joint that is too weak in some postures gets a `BrakingWarning`: the arm works in the others.

        Raises:
            ConfigurationError: A joint is too weak in half of the postures or more.
        """
        joint, arm = int(self.weak.argmax()), self._arm
        if self.weak[joint] == 0.0:
            return
        text = (
            f"{arm.name}: joint {arm.joint_names[joint]!r} cannot brake in {self.weak[joint]:.0%} of its postures, "
            f"because gravity and friction take up its torque limit of {arm.torque_limit[joint]:g} N·m"
        )
        if self.weak[joint] >= _MAX_WEAK:
            raise ConfigurationError(f"{text}; raise torque_limit or lighten the load")
        warnings.warn(f"{text}; keep away from these, or lighten the load", BrakingWarning, stacklevel=4)


def braking_acceleration(arm: ArmModel, share: float = BRAKING_SHARE) -> Array:
    """Return (nv,) a deceleration that every joint can hold in any posture [rad/s²].

    It is the smallest of `share spare / M_ii`, where `spare` is the torque that the limits leave beside gravity and
    friction. The other share is for coupling with other joints and for the load of the hand. The result is at least
    `MIN_BRAKING`.
    """
    return WorstCase(arm, share).braking


def _samples(arm: ArmModel) -> Iterator[tuple[Array, Array, Array]]:
    """Yield (nv,) spare torques [N·m], inertias M_ii [kg·m²] and gravity torques [N·m] of the joints at rest.

    The postures are a Kronecker sequence on the generalised golden ratio, so the answer never varies.
    """
    lower = np.where(np.isfinite(arm.q_lower), arm.q_lower, -np.pi)
    upper = np.where(np.isfinite(arm.q_upper), arm.q_upper, np.pi)
    steps = _steps(arm.nv)
    limit, spare, zero = TorqueLimit(arm), np.empty((2, arm.nv)), np.zeros(arm.nv)
    for sample in range(_SAMPLES):
        state = arm.update(lower + (upper - lower) * ((0.5 + sample * steps) % 1.0), zero)
        spare_torque(limit.S, limit.limit, state.h, spare)
        yield spare.min(axis=0) - arm.friction_coulomb, state.M.diagonal(), np.abs(state.h)


def _steps(dimension: int) -> Array:
    """Return (dimension,) the powers x^-1, x^-2 .. of the root above 1 of x^(dimension+1) = x + 1."""
    x = 2.0
    for _ in range(50):
        x = pow(1.0 + x, 1.0 / (dimension + 1.0))
    steps: Array = 1.0 / np.cumprod(np.full(dimension, x))
    return steps
