"""Feed-forward against joint friction, computed from the reference motion rather than the measured one."""

from __future__ import annotations

from math import hypot, inf

import numpy as np

from ..arm.friction import coulomb_torque
from ..arm.model import ArmModel
from ..exceptions import ConfigurationError
from ..tasks.frame_task import shorten
from ..types import Array, Reference
from .inverse_dynamics import InverseDynamics

FEED_FORWARD_SCALE = 0.02
"""Default joint velocity at which three quarters of the Coulomb friction are compensated [rad/s]; chosen."""
_MAX_APPROACH_SPEED = 0.1
"""Largest speed that the tool's position error asks for [m/s]; chosen, enough for all of the Coulomb friction."""
_MAX_APPROACH_ANGULAR_SPEED = 0.4
"""Largest angular velocity that the tool's orientation error asks for [rad/s]; chosen likewise."""


class FrictionCompensation:
    """Torque `gain (coulomb tanh(v* / scale) + viscous v*)` for the joint velocities v* that the reference asks for.

    The measured velocity is not used: its sign flips at rest, and the torque would chatter. v* is the damped
    pseudo-inverse's answer to the reference twist plus `error_rate` times the tool's pose error. The second part breaks
    loose a joint that sticks short of its goal. It asks for at most 0.1 m/s and 0.4 rad/s. That is enough for all of
    the Coulomb part, and it bounds the viscous part if a target is out of reach. No v* exceeds its joint's limit.
    The Coulomb part never exceeds the modelled friction, so a gain of 1 removes only what friction dissipates.

    Attributes:
        scale: Joint velocity at which three quarters of the Coulomb friction are compensated [rad/s].
        error_rate: Velocity asked for per error [1/s]; zero compensates the motion of the reference only.
        gain: Share of the modelled friction; choose it below 1 if the model may overestimate friction.
        coulomb: (nv,) Coulomb friction that is compensated [N·m].
        viscous: (nv,) Viscous friction that is compensated [N·m·s/rad].
        largest_approach: Largest speed [m/s] and angular speed [rad/s] that the error asks for.
    """

    largest_approach = _MAX_APPROACH_SPEED, _MAX_APPROACH_ANGULAR_SPEED

    def __init__(
        self, arm: ArmModel, scale: float = FEED_FORWARD_SCALE, error_rate: float = 8.0, gain: float = 1.0
    ) -> None:
        """Take the arm's friction.

        Args:
            arm: Model with the friction.
            scale: Joint velocity at which three quarters of the Coulomb friction are compensated [rad/s].
            error_rate: Velocity asked for per error [1/s]; zero compensates the motion of the reference only.
            gain: Share of the modelled friction.

        Raises:
            ConfigurationError: The scale is not positive, or the rate or the gain is negative or not finite.
        """
        if not 0.0 < scale < inf:
            raise ConfigurationError(f"scale = {scale} must be a positive joint velocity [rad/s]")
        for name, value in (("error_rate", error_rate), ("gain", gain)):
            if not 0.0 <= value < inf:
                raise ConfigurationError(f"{name} = {value} must be finite and not negative")
        self.scale, self.error_rate, self.gain = scale, error_rate, gain
        self.coulomb, self.viscous = gain * arm.friction_coulomb, gain * arm.friction_viscous
        self._scaled_viscous = scale * self.viscous
        self._is_zero = not (self.coulomb.any() or self._scaled_viscous.any())
        # numpy multiplies by an array faster than by a number, which it has to wrap first.
        self._rates, self._per_scale = np.full(6, error_rate), np.full(arm.nv, 1.0 / scale)
        self._limit = arm.velocity_limit
        self._least_limit = float(self._limit.min())

    def __repr__(self) -> str:
        return f"FrictionCompensation(scale={self.scale:g}, error_rate={self.error_rate:g}, gain={self.gain:g})"

    def torque(self, dynamics: InverseDynamics, reference: Reference, error: Array) -> Array | None:
        """Return (nv,) the feed-forward torque [N·m], None for an arm without friction.

        Args:
            dynamics: Program that was assembled for this period.
            reference: Reference of the tool.
            error: (6,) Error of the tool's pose [m, rad].
        """
        if self._is_zero:
            return None
        # A vector that is short as a whole is short in each part. This holds in nearly every period, here and below.
        twist = self._rates * error
        if hypot(*twist.tolist()) > _MAX_APPROACH_SPEED:
            shorten(twist[:3], _MAX_APPROACH_SPEED)
            shorten(twist[3:], _MAX_APPROACH_ANGULAR_SPEED)
        twist += reference.twist
        v = dynamics.joint_velocity(twist)
        if hypot(*v.tolist()) > self._least_limit:
            v = np.minimum(np.maximum(v, -self._limit), self._limit)
        # Velocities in units of the scale, so that the scale of the law is 1.
        scaled = v * self._per_scale
        return coulomb_torque(scaled, self.coulomb, 1.0) + scaled * self._scaled_viscous


def make_compensation(
    arm: ArmModel, friction: FrictionCompensation | bool, **options: float
) -> FrictionCompensation | None:
    """Return the feed-forward that a controller's argument `friction` asks for.

    Args:
        arm: Model with the friction.
        friction: Feed-forward itself, True for a new one, or False for none.
        options: Arguments of a new `FrictionCompensation`.
    """
    if isinstance(friction, bool):
        return FrictionCompensation(arm, **options) if friction else None
    return friction
