"""Limits on speeds and positions of the joints, as bounds on the accelerations of one control period."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..arm.fitting import check_arm, check_rate
from ..arm.model import ArmModel
from ..arm.state import ArmState
from ..exceptions import ConfigurationError
from ..kernels.joint_limits import position_limit, velocity_bounds
from ..types import Array
from .braking import BRAKING_SHARE, WorstCase
from .braking import braking_acceleration as braking_acceleration
from .limit import Bounds
from .torque_limit import TorqueLimit

HORIZON_PERIODS = 2.0
"""Number of control periods that velocity and position limits look ahead; chosen, the fewest without chatter."""
VELOCITY_MARGIN = 0.05
"""Fraction of a speed limit that is kept in reserve for an arm without joint friction; see `VelocityLimit`."""
FRICTION_VELOCITY_MARGIN = 0.07
"""Fraction of a speed limit that is kept in reserve for an arm with joint friction; see `VelocityLimit`."""
POSITION_MARGIN = 0.002
"""Distance kept from a position limit [rad]; chosen; covers the error of a constant acceleration over a period."""
MIN_STOPPING_TIME = 0.05
"""Time constant of the last part of the way to a position limit [s]; chosen, so that the torques do not chatter."""
RETREAT = 0.3
"""Speed at which a joint returns that is found outside its range [rad/s]; chosen."""
_DEFAULT_SPEED = 2.0
"""Full speed of a joint that has no velocity limit [rad/s]; chosen."""
DEMAND = 4.0
"""Largest deceleration that a position bound may demand, over the joint's present one; chosen.

On the border of the states from which a joint can brake, a bound demands the present deceleration. Beyond the border,
as after a push, it may take twice the torque that is left, because the other joints can give way.
"""
GENTLE_DEMAND = 1.25
"""Largest acceleration of a joint's return into its range or speed limit, over `braking_acceleration`; chosen.

A larger demand could exceed the torques, and the bounds of all joints would then be softened.
"""


class VelocityLimit:
    """Keeps |v| within the arm's limit at the end of a horizon: a <= (v_max - v) / horizon, and likewise below.

    A horizon of two control periods halves the distance to the limit in each period instead of using it up in one, so
    the bound does not chatter. The torque is held while the arm moves on, so the acceleration that follows differs from
    the computed one. An acceleration error of d leaves the speed `horizon d` too high, and the margin covers that: 5 %
    of 2 rad/s cover 25 rad/s² at 500 Hz. With joint friction, a joint that changes its direction reverses its friction
    within a period, and this disturbs a light wrist beside it. The margin is then 7 %.

    A joint without a velocity limit is free. A joint that is found above its limit slows down with at most
    `GENTLE_DEMAND` times its `braking_acceleration`.

    Attributes:
        name: Name of the limit in `active_limits`.
        arm: Arm with the limits.
        rate: Control rate [Hz].
        row_names: (nv,) Names in `active_limits`, such as "velocity[0]".
        speed: (nv,) Largest speeds, `margin` below the arm's [rad/s].
        horizon: Time until the end of the horizon [s].
    """

    name = "velocity"
    hard = False

    def __init__(
        self,
        arm: ArmModel,
        rate: float = 500.0,
        *,
        horizon_periods: float = HORIZON_PERIODS,
        margin: float | None = None,
    ) -> None:
        """Set the limit for control at `rate`.

        Args:
            arm: Arm with the limits.
            rate: Control rate [Hz].
            horizon_periods: Number of control periods that the bound looks ahead.
            margin: Fraction of the speed that is kept in reserve; by default 0.05, or 0.07 for an arm with friction.

        Raises:
            ConfigurationError: A number is out of range.
        """
        check_arm(arm, "VelocityLimit")
        self.arm, self.rate = arm, check_rate(rate)
        self.horizon = _number("horizon_periods", horizon_periods, np.inf) / self.rate
        self.speed = _kept_speed(arm, margin)
        self._worst = WorstCase(arm)
        self.row_names = tuple(f"{self.name}[{joint}]" for joint in range(arm.nv))

    def numbers(self, arm: ArmModel) -> tuple[Any, ...]:
        """Return the numbers of `velocity_bounds` for an arm with its payload, for a kernel that calls it."""
        return self.speed, self._worst.of(arm).braking, self.horizon, GENTLE_DEMAND

    def __repr__(self) -> str:
        return f"VelocityLimit(speed={np.round(self.speed, 4).tolist()}, horizon={self.horizon:g})"

    def rows(self, state: ArmState) -> Bounds:
        """Return the bounds on the joint accelerations [rad/s²]."""
        lower, upper = np.empty(len(self.speed)), np.empty(len(self.speed))
        least = self._worst.of(state.arm).braking
        velocity_bounds(state.v, self.speed, least, self.horizon, GENTLE_DEMAND, lower, upper)
        return Bounds(None, lower, upper, self.row_names)


class PositionLimit:
    """Keeps each joint able to stop before its position limit, and leaves it alone while it can.

    At distance d from a limit, a joint that decelerates with b can stop from the speed w with `w² = 2 b d`. This is the
    border of the viable states of Del Prete, "Joint position and velocity bounds in discrete-time acceleration/torque
    control of robot manipulators", RA-L 3(1), 2018. The bound keeps the speed at the end of a horizon of two control
    periods within it. Near the limit the border is a line, `w = d / stopping_time`, which meets the parabola smoothly.
    The joint then approaches its limit exponentially, and the torque does not chatter.

    The deceleration is that of the present state, `share (spare - friction) / M_ii`. `spare` is the torque that h
    leaves of the limits, those of shared motors too, in the direction that brakes. The other share is for coupling with
    other joints. Gravity may hinder more on the way. Its torque G in the worst posture changes by at most G per radian.
    The deceleration therefore falls with at most the slope `share G / M_ii`, and never below the least over all
    postures. b is the mean over the distance.

    A joint that is found outside its range returns at the speed `retreat`, or that of `VelocityLimit` if it is lower.
    It accelerates with at most `GENTLE_DEMAND` times its least deceleration.

    Attributes:
        name: Name of the limit in `active_limits`.
        arm: Arm with the limits.
        rate: Control rate [Hz].
        row_names: (nv,) Names in `active_limits`, such as "position[0]".
        lower: (nv,) Lower position limits with the margin [rad].
        upper: (nv,) Upper position limits with the margin [rad].
        horizon: Time until the end of the horizon [s].
        gain: (nv,) Speed over distance from which each joint can stop in any posture [1/s].
    """

    name = "position"
    hard = False

    def __init__(
        self,
        arm: ArmModel,
        rate: float = 500.0,
        *,
        horizon_periods: float = HORIZON_PERIODS,
        margin: float = POSITION_MARGIN,
        share: float = BRAKING_SHARE,
        stopping_time: float = MIN_STOPPING_TIME,
        retreat: float = RETREAT,
    ) -> None:
        """Set the limit for control at `rate`.

        Args:
            arm: Arm with the limits.
            rate: Control rate [Hz].
            horizon_periods: Number of control periods that the bound looks ahead.
            margin: Distance kept from either limit [rad].
            share: Share of the spare torque that brakes.
            stopping_time: Time constant of the last part of the way to a limit [s].
            retreat: Speed at which a joint returns that is found outside its range [rad/s].

        Raises:
            ConfigurationError: A number is out of range, or gravity takes up the torque limit of a joint in half of its
                postures or more. In fewer postures, the joint gets a `BrakingWarning`.
        """
        check_arm(arm, "PositionLimit")
        self.arm, self.rate = arm, check_rate(rate)
        self.horizon = _number("horizon_periods", horizon_periods, np.inf) / self.rate
        self._share = _number("share", share, 1.0)
        self._last_gain = 1.0 / _number("stopping_time", stopping_time, np.inf)
        self._retreat = np.minimum(_number("retreat", retreat, np.inf), _kept_speed(arm, None))
        kept = np.minimum(_number("margin", margin, np.inf, zero=True), 0.25 * (arm.q_upper - arm.q_lower))
        self.lower, self.upper = arm.q_lower + kept, arm.q_upper - kept
        self._worst = WorstCase(arm, self._share)
        self.check(arm)
        full_speed = np.where(np.isfinite(arm.velocity_limit), arm.velocity_limit, _DEFAULT_SPEED)
        self.gain = np.minimum(self._worst.braking / full_speed, self._last_gain)
        self._friction = arm.friction_coulomb
        self._torque = TorqueLimit(arm)
        self.row_names = tuple(f"{self.name}[{joint}]" for joint in range(arm.nv))

    def numbers(self, arm: ArmModel) -> tuple[Any, ...]:
        """Return the numbers of the kernel `position_limit` for an arm with its payload."""
        worst = self._worst.of(arm)
        return (
            *(self.lower, self.upper, self._friction, worst.gravity, self._share, worst.braking, self._retreat),
            *(self._last_gain, self.horizon, DEMAND, GENTLE_DEMAND),
        )

    def check(self, arm: ArmModel) -> None:
        """Name a joint that cannot brake under the arm's payload; see `WorstCase.check`.

        Raises:
            ConfigurationError: A joint is too weak in half of its postures or more.
        """
        self._worst.of(arm).check()

    def __repr__(self) -> str:
        return f"PositionLimit(lower={np.round(self.lower, 4).tolist()}, upper={np.round(self.upper, 4).tolist()})"

    def rows(self, state: ArmState) -> Bounds:
        """Return the bounds on the joint accelerations [rad/s²]."""
        lower, upper = np.empty(len(self.lower)), np.empty(len(self.lower))
        torque = self._torque.S, self._torque.limit
        position_limit(state.q, state.v, state.M, state.h, *torque, *self.numbers(state.arm), lower, upper)
        return Bounds(None, lower, upper, self.row_names)


def _kept_speed(arm: ArmModel, margin: float | None) -> Array:
    """Return (nv,) the velocity limits less the margin, by default that of an arm with or without friction [rad/s]."""
    if margin is None:
        margin = FRICTION_VELOCITY_MARGIN if arm.friction_coulomb.any() else VELOCITY_MARGIN
    speed: Array = (1.0 - _number("margin", margin, 1.0, zero=True)) * arm.velocity_limit
    return speed


def _number(name: str, value: Any, upper: float, zero: bool = False) -> float:
    """Return a positive number below `upper`; with `zero`, zero too.

    Raises:
        ConfigurationError: The value is none.
    """
    good = isinstance(value, int | float | np.number) and (0.0 < value < upper or (zero and value == 0.0))
    if not good:
        below = "" if upper == np.inf else f" below {upper:g}"
        raise ConfigurationError(f"{name} = {value!r:.80} must be a {'' if zero else 'positive '}number{below}")
    return float(value)
