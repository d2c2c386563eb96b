"""Feed-forward against joint friction, from where the tool shall go rather than from where it goes."""

from __future__ import annotations

from math import hypot, inf

import numpy as np

from ..arm.model import ArmModel
from ..exceptions import ConfigurationError
from ..tasks.frame_task import shorten
from ..types import Array, Reference
from .inverse_dynamics import InverseDynamics

_APPROACH_SPEED = 0.1
_APPROACH_TURN = 0.4


class FrictionCompensation:
    """Torque `gain (coulomb tanh(v* / scale) + viscous v*)` for the joint velocities v* that the reference asks for.

    The measured velocity is not used: its sign flips at rest and the torque would chatter. v* is the damped
    pseudo-inverse's answer to the reference twist plus `error_rate` times the tool's pose error. The second part breaks
    a joint loose that sticks short of its goal; at most 0.1 m/s and 0.4 rad/s are asked for, which is enough for all
    of the Coulomb part and bounds the viscous one where a target is out of reach. No v* exceeds its joint's limit.
    The Coulomb part never exceeds the modelled friction, so that a gain of 1 only takes away what friction dissipates.

    Buffers are reused between calls, so one instance serves one thread.

    Attributes:
        scale: joint velocity at which three quarters of the Coulomb friction are compensated [rad/s].
        error_rate: [1/s]; zero compensates the reference's own motion only.
        gain: share of the modelled friction; below 1 where the model may claim too much.
        coulomb: (nv,) Coulomb friction that is compensated [N·m].
        viscous: (nv,) viscous friction that is compensated [N·m·s/rad].
        largest_approach: what is asked for at most because of the error [m/s], [rad/s].
    """

    largest_approach = _APPROACH_SPEED, _APPROACH_TURN

    def __init__(self, arm: ArmModel, scale: float = 0.02, error_rate: float = 8.0, gain: float = 1.0) -> None:
        """Take the arm's friction.

        Raises:
            ConfigurationError: where the scale is not positive, or the rate or the gain is negative or not finite.
        """
        if not 0.0 < scale < inf:
            raise ConfigurationError(f"scale = {scale} must be a positive joint velocity [rad/s]")
        for name, value in (("error_rate", error_rate), ("gain", gain)):
            if not 0.0 <= value < inf:
                raise ConfigurationError(f"{name} = {value} must be finite and not negative")
        self.scale, self.error_rate, self.gain = scale, error_rate, gain
        self.coulomb, self.viscous = gain * arm.friction_coulomb, gain * arm.friction_viscous
        self._factors = np.stack((self.coulomb, scale * self.viscous))
        self._none = not self._factors.any()
        # numpy multiplies by an array faster than by a number, which it has to wrap first.
        self._rates, self._per_scale = np.full(6, error_rate), np.full(arm.nv, 1.0 / scale)
        self._parts = np.zeros_like(self._factors)
        self._saturated, self._linear = self._parts
        self._limit = arm.velocity_limit
        self._least_limit = float(self._limit.min())

    def torque(self, dynamics: InverseDynamics, reference: Reference, error: Array) -> Array | None:
        """Return (nv,) the feed-forward torque [N·m], None for an arm without friction.

        Args:
            dynamics: the program, assembled for this period.
            reference: where the tool should be.
            error: (6,) how far it is from there.
        """
        if self._none:
            return None
        # Both comparisons pass by what is short enough as a whole, and so in each part: nearly every period.
        twist = self._rates * error
        if hypot(*twist.tolist()) > _APPROACH_SPEED:
            shorten(twist[:3], _APPROACH_SPEED)
            shorten(twist[3:], _APPROACH_TURN)
        twist += reference.twist
        v = dynamics.joint_velocity(twist)
        if hypot(*v.tolist()) > self._least_limit:
            v = np.minimum(np.maximum(v, -self._limit), self._limit)
        # Both parts of the law in one array: what a call costs is the call, not seven numbers.
        parts, linear = self._parts, self._linear
        np.multiply(v, self._per_scale, linear)
        np.tanh(linear, self._saturated)
        np.multiply(parts, self._factors, parts)
        return self._saturated + linear
