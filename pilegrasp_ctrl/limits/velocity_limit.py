"""Joint speeds, as bounds on the accelerations of one control period."""

from __future__ import annotations

import numpy as np

from ..arm.model import ArmModel
from .constraint import AffineBounds

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
