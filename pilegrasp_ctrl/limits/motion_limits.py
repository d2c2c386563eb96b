"""Limits on speeds and positions of the joints, as bounds on the accelerations of one control period."""

from __future__ import annotations

import numpy as np

from ..arm.model import ArmModel
from ..types import Array
from .acceleration_bounds import AffineBounds

HORIZON_PERIODS = 2.0
"""Number of control periods that velocity and position limits look ahead; chosen, the fewest without chatter."""
VELOCITY_MARGIN = 0.05
"""Fraction of a speed limit that is kept in reserve for an arm without joint friction; see `VelocityLimit`."""
FRICTION_VELOCITY_MARGIN = 0.07
"""Fraction of a speed limit that is kept in reserve for an arm with joint friction; see `VelocityLimit`."""
POSITION_MARGIN = 0.002
"""Distance kept from a position limit [rad]; chosen; covers the error of a constant acceleration over a period."""
MIN_STOPPING_TIME = 0.05
"""Shortest time in which a joint needs to stop from full speed [s]; chosen."""
_DEFAULT_SPEED = 2.0
"""Full speed of a joint that has no velocity limit [rad/s]; chosen."""
_BRAKING_SHARE = 0.5
"""Share of the torque left by gravity and friction that brakes; the rest is for coupling and load. Chosen."""
_MIN_BRAKING = 0.1
"""Least braking acceleration, as a share of full speed per second [1/s]; chosen."""
_SAMPLES = 64
"""Number of postures at which the braking acceleration is evaluated; chosen."""


class VelocityLimit:
    """Keeps |v| within the arm's limit at the end of a horizon: a <= (v_max - v) / horizon, and likewise below.

    A horizon of two control periods halves the distance to the limit in each period instead of using it up in one, so
    the bound does not chatter. The torque is held while the arm moves on, so the acceleration that follows differs from
    the computed one. An acceleration error of d leaves the speed `horizon d` too high, and the margin covers that: 5 %
    of 2 rad/s cover 25 rad/s² at 500 Hz. With joint friction, a joint that changes its direction reverses its friction
    within a period, and this disturbs a light wrist beside it. The margin is then 7 %.

    Attributes:
        name: Name of the limit in `active_limits`.
        speed: (nv,) Largest speeds, `margin` below the arm's [rad/s].
        horizon: Time until the end of the horizon [s].
    """

    name = "velocity"

    def __init__(
        self,
        arm: ArmModel,
        rate: float,
        horizon_periods: float = HORIZON_PERIODS,
        margin: float | None = None,
    ) -> None:
        """Set the limit for control at `rate`.

        Args:
            arm: Arm with the limits.
            rate: Control rate [Hz].
            horizon_periods: Number of control periods that the bound looks ahead.
            margin: Fraction of the speed that is kept in reserve; by default 0.05, or 0.07 for an arm with friction.
        """
        if margin is None:
            margin = FRICTION_VELOCITY_MARGIN if arm.friction_coulomb.any() else VELOCITY_MARGIN
        self.horizon = horizon_periods / rate
        self.speed = (1.0 - margin) * arm.velocity_limit

    def __repr__(self) -> str:
        return f"VelocityLimit(speed={np.round(self.speed, 4).tolist()}, horizon={self.horizon:g})"

    def bounds(self) -> AffineBounds:
        """Return the bounds as a function of the state."""
        matrix = np.hstack((np.zeros((len(self.speed),) * 2), -np.eye(len(self.speed)) / self.horizon))
        return AffineBounds(matrix, -self.speed / self.horizon, matrix, self.speed / self.horizon)


class PositionLimit:
    """Keeps each joint able to stop before its position limit.

    The speed toward a limit at distance d is kept at or below `gain d`, at the end of a horizon T of two control
    periods. With a constant acceleration over T, `v + T a <= gain (q_max - q - T v - T² a / 2)` gives

        a <= (gain (q_max - q) - (1 + gain T) v) / (T (1 + gain T / 2))

    and the mirror image below. Along the border of that set the joint brakes with at most `gain v_max`. The gain is
    therefore the braking acceleration that the torques allow, divided by the largest speed, and at most 1 /
    `MIN_STOPPING_TIME`. The set stays invariant, and the joint approaches its limit exponentially. A joint that starts
    beyond its limit returns at the same rate. The set is the linear subset of the viable states of Del Prete, "Joint
    position and velocity bounds in discrete-time acceleration/torque control of robot manipulators", RA-L 3(1), 2018.
    The border of those states is a parabola.

    Attributes:
        name: Name of the limit in `active_limits`.
        gain: (nv,) Largest speed over distance [1/s].
        horizon: Time until the end of the horizon [s].
    """

    name = "position"

    def __init__(
        self,
        arm: ArmModel,
        rate: float,
        horizon_periods: float = HORIZON_PERIODS,
        margin: float = POSITION_MARGIN,
        braking: Array | None = None,
    ) -> None:
        """Set the limit for control at `rate`.

        Args:
            arm: Arm with the limits.
            rate: Control rate [Hz].
            horizon_periods: Number of control periods that the bound looks ahead.
            margin: Distance kept from either limit [rad].
            braking: (nv,) Deceleration that every joint can hold [rad/s²]; `braking_acceleration(arm)` by default.
        """
        braking = braking_acceleration(arm) if braking is None else np.asarray(braking, dtype=np.float64)
        self.gain = np.minimum(braking / _full_speed(arm), 1.0 / MIN_STOPPING_TIME)
        self.horizon = horizon_periods / rate
        kept = np.minimum(margin, 0.25 * (arm.q_upper - arm.q_lower))
        self._lower, self._upper = arm.q_lower + kept, arm.q_upper - kept

    def __repr__(self) -> str:
        return f"PositionLimit(gain={np.round(self.gain, 4).tolist()}, horizon={self.horizon:g})"

    def bounds(self) -> AffineBounds:
        """Return the bounds as a function of the state."""
        scale = 1.0 / (self.horizon * (1.0 + 0.5 * self.gain * self.horizon))
        matrix = np.hstack((np.diag(-scale * self.gain), np.diag(-scale * (1.0 + self.gain * self.horizon))))
        stiffness = scale * self.gain
        return AffineBounds(matrix, stiffness * self._lower, matrix, stiffness * self._upper)


def braking_acceleration(arm: ArmModel) -> Array:
    """Return (nv,) a deceleration that every joint can hold in any posture [rad/s²].

    It is the smallest of `share (torque limit - |gravity| - friction) / M_ii` over postures spread evenly between the
    position limits. The postures are a Kronecker sequence on the generalised golden ratio, so the answer never varies.
    The share is one half: the rest is for coupling with other joints and for the load of the hand. The result is at
    least a tenth of full speed per second. For a light wrist it is far more than needed.
    """
    lower = np.where(np.isfinite(arm.q_lower), arm.q_lower, -np.pi)
    upper = np.where(np.isfinite(arm.q_upper), arm.q_upper, np.pi)
    ratio = _golden_ratio(arm.nv)
    steps = ratio ** -np.arange(1.0, arm.nv + 1.0)
    least = np.full(arm.nv, np.inf)
    for sample in range(_SAMPLES):
        q = lower + (upper - lower) * ((0.5 + sample * steps) % 1.0)
        state = arm.update(q, np.zeros(arm.nv))
        spare = arm.torque_limit - np.abs(state.h) - arm.friction_coulomb
        np.minimum(least, _BRAKING_SHARE * spare / state.M.diagonal(), out=least)
    return np.maximum(least, _MIN_BRAKING * _full_speed(arm))


def _full_speed(arm: ArmModel) -> Array:
    return np.where(np.isfinite(arm.velocity_limit), arm.velocity_limit, _DEFAULT_SPEED)


def _golden_ratio(dimension: int) -> float:
    """Return the root above 1 of x^(d+1) = x + 1."""
    x = 2.0
    for _ in range(50):
        x = (1.0 + x) ** (1.0 / (dimension + 1.0))
    return x
