"""How hard each joint can brake wherever the arm may be."""

from __future__ import annotations

import numpy as np

from ..arm.model import ArmModel
from ..types import Array

_SAMPLES = 64
_SHARE = 0.5


def braking_acceleration(arm: ArmModel) -> Array:
    """Return (nv,) a deceleration that every joint can hold wherever the arm is [rad/s²].

    The smallest of `share (torque limit - |gravity| - friction) / M_ii` over postures spread evenly between the
    position limits (a Kronecker sequence on the generalised golden ratio, so the answer never varies). Half of what
    is left is taken, for the coupling with other joints and what the hand carries; never less than a tenth of full
    speed per second. A light wrist has far more than it needs.
    """
    lower = np.where(np.isfinite(arm.q_lower), arm.q_lower, -np.pi)
    upper = np.where(np.isfinite(arm.q_upper), arm.q_upper, np.pi)
    speed = np.where(np.isfinite(arm.velocity_limit), arm.velocity_limit, 2.0)
    ratio = _golden_ratio(arm.nv)
    steps = ratio ** -np.arange(1.0, arm.nv + 1.0)
    least = np.full(arm.nv, np.inf)
    for sample in range(_SAMPLES):
        q = lower + (upper - lower) * ((0.5 + sample * steps) % 1.0)
        state = arm.update(q, np.zeros(arm.nv))
        spare = arm.torque_limit - np.abs(state.h) - arm.friction_coulomb
        np.minimum(least, _SHARE * spare / state.M.diagonal(), out=least)
    return np.maximum(least, 0.1 * speed)


def _golden_ratio(dimension: int) -> float:
    """Return the root above 1 of x^(d+1) = x + 1."""
    x = 2.0
    for _ in range(50):
        x = (1.0 + x) ** (1.0 / (dimension + 1.0))
    return x
