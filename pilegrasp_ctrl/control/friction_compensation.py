"""Feed-forward against joint friction, computed from the reference motion rather than the measured one."""

from __future__ import annotations

from math import inf

import numpy as np

from ..arm.fitting import check_same_arm
from ..arm.model import ArmModel
from ..exceptions import ConfigurationError
from ..kernels.friction import clip, friction_torque
from ..types import Array

FEED_FORWARD_SCALE = 0.02
"""Default joint velocity at which three quarters of the Coulomb friction are compensated [rad/s]; chosen."""
ERROR_RATE = 8.0
"""Default velocity asked for per error [1/s]; chosen."""


class FrictionCompensation:
    """Torque `gain (coulomb tanh(v* / scale) + viscous v*)` for the joint velocities v* that the tasks ask for.

    The measured velocity is not used: its sign flips at rest, and the torque would chatter. The damped pseudo-inverse
    gives v* for the reference twist plus `error_rate` times the pose error. The second part breaks loose a joint that
    sticks short of its goal. It asks for at most 0.1 m/s and 0.4 rad/s. That is enough for all of the Coulomb part, and
    it bounds the viscous part if a target is out of reach. No v* exceeds its joint's limit. The Coulomb part never
    exceeds the modelled friction, so a gain of 1 removes only what friction dissipates.

    Attributes:
        arm: Model with the friction.
        scale: Joint velocity at which three quarters of the Coulomb friction are compensated [rad/s].
        error_rate: Velocity asked for per error [1/s]; zero compensates the motion of the reference only.
        gain: Share of the modelled friction; choose it below 1 if the model may overestimate friction.
        coulomb: (nv,) Coulomb friction that is compensated [N·m].
        viscous: (nv,) Viscous friction that is compensated [N·m·s/rad].
        velocity_limit: (nv,) Largest joint velocities that are compensated [rad/s].
        is_zero: Whether there is nothing to compensate.
    """

    def __init__(
        self, arm: ArmModel, scale: float = FEED_FORWARD_SCALE, error_rate: float = ERROR_RATE, gain: float = 1.0
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
        self.arm = arm
        self.scale, self.error_rate, self.gain = scale, error_rate, gain
        self.coulomb, self.viscous = gain * arm.friction_coulomb, gain * arm.friction_viscous
        self.is_zero = not (self.coulomb.any() or self.viscous.any())
        self.velocity_limit = arm.velocity_limit

    def __repr__(self) -> str:
        return f"FrictionCompensation(scale={self.scale:g}, error_rate={self.error_rate:g}, gain={self.gain:g})"

    def torque(self, velocity: Array) -> Array:
        """Return (nv,) the feed-forward torque [N·m] for the joint velocities (nv,) that the tasks ask for [rad/s]."""
        v, torque = np.empty(len(velocity)), np.empty(len(velocity))
        clip(velocity, self.velocity_limit, v)
        friction_torque(v, self.coulomb, self.viscous, self.scale, torque)
        return torque


def make_compensation(
    arm: ArmModel, friction: FrictionCompensation | bool, **options: float
) -> FrictionCompensation | None:
    """Return the feed-forward that a controller's argument `friction` asks for; None where it would be zero.

    Args:
        arm: Model with the friction.
        friction: Feed-forward itself, True for a new one, or False for none.
        options: Arguments of a new `FrictionCompensation`.

    Raises:
        ConfigurationError: `friction` is something else.
    """
    if isinstance(friction, bool):
        friction = FrictionCompensation(arm, **(options if friction else {"gain": 0.0}))
    if not isinstance(friction, FrictionCompensation):
        raise ConfigurationError(f"friction = {friction!r:.80} must be True, False or a FrictionCompensation")
    check_same_arm(friction, arm)
    return None if friction.is_zero else friction
