"""Joint positions, as bounds on the accelerations of one control period."""

from __future__ import annotations

import numpy as np

from ..arm.model import ArmModel
from ..types import Array
from .braking import braking_acceleration
from .constraint import AffineBounds

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
