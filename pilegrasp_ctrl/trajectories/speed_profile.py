"""The speed profile along a path: from rest to a constant speed and back to rest."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf, sqrt

from ..exceptions import ArgumentError

PEAK_TO_MEAN_ACCELERATION = 1.5
"""Peak acceleration of a ramp over its mean acceleration [-]: the maximum of 6 u (1 - u)."""

MAX_ACCELERATION = 0.5
"""Default peak acceleration along a path [m/s²]; chosen."""

MAX_ANGULAR_SPEED = 0.5
"""Default largest angular speed of a tool that turns [rad/s]; chosen."""

MAX_ANGULAR_ACCELERATION = 2.5
"""Default peak angular acceleration of a tool that turns [rad/s²]; chosen."""


def require_positive(**values: float) -> None:
    """Check that every value is positive and finite.

    Raises:
        ArgumentError: A value is not positive and finite.
    """
    for name, value in values.items():
        if not 0.0 < value < inf:
            raise ArgumentError(f"{name} = {value} must be positive and finite")


@dataclass(frozen=True, slots=True)
class SpeedProfile:
    """Distance along a path over time, with continuous acceleration.

    The speed rises as `V (3 u² - 2 u³)`, with u from 0 to 1 over the ramp time, stays constant, and falls likewise. The
    acceleration is zero at both ends of a ramp and peaks at `1.5 V / ramp time`. On a short path the speed is lowered
    so that the two ramps just meet.

    Attributes:
        length: Length of the path [m or rad].
        speed: Requested speed [m/s or rad/s].
        acceleration: Peak acceleration [m/s² or rad/s²].
        peak_speed: Speed that is reached [m/s or rad/s].
        ramp: Duration of one ramp [s].
        duration: Time from rest to rest [s].

    Raises:
        ArgumentError: The length is negative, speed or acceleration is not positive, or a value is not finite.
    """

    length: float
    speed: float
    acceleration: float
    peak_speed: float = field(init=False)
    ramp: float = field(init=False)
    duration: float = field(init=False)

    def __post_init__(self) -> None:
        if not 0.0 <= self.length < inf:
            raise ArgumentError(f"length = {self.length} must be finite and not negative")
        require_positive(speed=self.speed, acceleration=self.acceleration)
        peak = min(self.speed, sqrt(self.length * self.acceleration / PEAK_TO_MEAN_ACCELERATION))
        ramp = PEAK_TO_MEAN_ACCELERATION * peak / self.acceleration
        object.__setattr__(self, "peak_speed", peak)
        object.__setattr__(self, "ramp", ramp)
        object.__setattr__(self, "duration", ramp + self.length / peak if peak > 0.0 else 0.0)

    def at(self, time: float) -> tuple[float, float, float]:
        """Return position along the path, speed and acceleration at `time` [s]; at rest before 0 and after the end."""
        if time <= 0.0:
            return 0.0, 0.0, 0.0
        left = self.duration - time
        if left <= 0.0:
            return self.length, 0.0, 0.0
        if time < self.ramp:
            return self._on_ramp(time)
        if left < self.ramp:
            position, speed, acceleration = self._on_ramp(left)
            return self.length - position, speed, -acceleration
        return self.peak_speed * (time - 0.5 * self.ramp), self.peak_speed, 0.0

    def _on_ramp(self, time: float) -> tuple[float, float, float]:
        u = time / self.ramp
        position = self.peak_speed * self.ramp * u * u * u * (1.0 - 0.5 * u)
        return position, self.peak_speed * u * u * (3.0 - 2.0 * u), self.peak_speed / self.ramp * 6.0 * u * (1.0 - u)


RESTING = SpeedProfile(0.0, 1.0, 1.0)
"""Profile of a path of length zero."""
