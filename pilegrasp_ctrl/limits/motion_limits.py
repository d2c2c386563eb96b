"""Speeds and positions of the joints, as bounds on the accelerations of one control period."""

from __future__ import annotations

import numpy as np

from ..arm.model import ArmModel
from ..types import Array
from .acceleration_bounds import AffineBounds

MARGIN, FRICTION_MARGIN = 0.05, 0.07
"""Fraction of a speed limit that is kept in reserve, for an arm without and with joint friction."""


class VelocityLimit:
    """Keeps |v| within the arm's limit at the end of a horizon: a <= (v_max - v) / horizon, and so below.

    A horizon of two control periods halves the distance to the limit each period instead of using it up in one, so
    that the bound does not chatter. The torque is held while the arm moves on, so the acceleration that it was computed
    for is not quite the one that follows; an error of d leaves the speed `horizon d` above where it should stay, and
    the margin is for that: 5 % of 2 rad/s cover 25 rad/s² at 500 Hz. Where joints rub, a neighbour that changes its
    direction turns its friction round within a period, and a light wrist feels that; there the margin is 7 %.

    Attributes:
        name: how `active_limits` calls it.
        speed: (nv,) largest speeds, `margin` below the arm's [rad/s].
        horizon: [s].
    """

    name = "velocity"

    def __init__(self, arm: ArmModel, rate: float, horizon_periods: float = 2.0, margin: float | None = None) -> None:
        """Fix the limit for control at `rate` [Hz].

        Args:
            arm: the arm.
            rate: control rate [Hz].
            horizon_periods: how far the bound looks ahead.
            margin: fraction of the speed kept in reserve; where absent, 0.05, and 0.07 for an arm with friction.
        """
        if margin is None:
            margin = FRICTION_MARGIN if arm.friction_coulomb.any() else MARGIN
        self.horizon = horizon_periods / rate
        self.speed = (1.0 - margin) * arm.velocity_limit

    def bounds(self) -> AffineBounds:
        """Return the bounds as a function of the state."""
        matrix = np.hstack((np.zeros((len(self.speed),) * 2), -np.eye(len(self.speed)) / self.horizon))
        return AffineBounds(matrix, -self.speed / self.horizon, matrix, self.speed / self.horizon)


STOPPING_TIME = 0.05
"""No joint needs to stop from full speed any faster [s]."""


class PositionLimit:
    """Keeps each joint able to stop before its position limit.

    The speed toward a limit at distance d is kept at or below `gain d`, at the end of a horizon T of two control
    periods. With a constant acceleration over T, `v + T a <= gain (q_max - q - T v - T² a / 2)` gives

        a <= (gain (q_max - q) - (1 + gain T) v) / (T (1 + gain T / 2))

    and the mirror image below. Along the border of that set the joint brakes with at most `gain v_max`, so the gain
    is the braking acceleration that the torques allow over the largest speed, at most 1 / `STOPPING_TIME`: the set
    stays invariant, the joint approaches its limit exponentially, and a joint found beyond its limit returns at the
    same rate. It is the linear subset of the viable states of Del Prete, "Joint position and velocity bounds in
    discrete-time acceleration/torque control of robot manipulators", RA-L 3(1), 2018, whose border is a parabola.

    Attributes:
        name: how `active_limits` calls it.
        gain: (nv,) largest speed over distance [1/s].
        horizon: [s].
    """

    name = "position"

    def __init__(
        self,
        arm: ArmModel,
        rate: float,
        horizon_periods: float = 2.0,
        margin: float = 0.002,
        braking: Array | None = None,
    ) -> None:
        """Fix the limit for control at `rate` [Hz].

        Args:
            arm: the arm.
            rate: control rate [Hz].
            horizon_periods: how far the bound looks ahead.
            margin: kept from either limit, for what a period's constant acceleration leaves out [rad].
            braking: (nv,) deceleration that may be relied on [rad/s²]; `braking_acceleration(arm)` where absent.
        """
        braking = braking_acceleration(arm) if braking is None else np.asarray(braking, dtype=np.float64)
        speed = np.where(np.isfinite(arm.velocity_limit), arm.velocity_limit, 2.0)
        self.gain = np.minimum(braking / speed, 1.0 / STOPPING_TIME)
        self.horizon = horizon_periods / rate
        kept = np.minimum(margin, 0.25 * (arm.q_upper - arm.q_lower))
        self._lower, self._upper = arm.q_lower + kept, arm.q_upper - kept

    def bounds(self) -> AffineBounds:
        """Return the bounds as a function of the state."""
        scale = 1.0 / (self.horizon * (1.0 + 0.5 * self.gain * self.horizon))
        matrix = np.hstack((np.diag(-scale * self.gain), np.diag(-scale * (1.0 + self.gain * self.horizon))))
        stiffness = scale * self.gain
        return AffineBounds(matrix, stiffness * self._lower, matrix, stiffness * self._upper)


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
