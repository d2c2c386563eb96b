"""How fast to go along a path: from rest to a constant speed and back to rest."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf, sqrt

_PEAK = 1.5


@dataclass(frozen=True, slots=True)
class SpeedProfile:
    """Path length over time with continuous acceleration.

    The speed rises as `V (3 u² - 2 u³)`, u from 0 to 1 over the ramp's time, stays, and falls likewise; the
    acceleration is zero at both ends of a ramp and peaks at `1.5 V / ramp time`. On a short path the speed is lowered
    so that the two ramps just meet.

    Attributes:
        length: of the path [m or rad].
        speed: wanted speed [m/s or rad/s].
        acceleration: peak acceleration [m/s² or rad/s²].
        peak_speed: the speed that is reached.
        ramp: time of one ramp [s].
        duration: from rest to rest [s].

    Raises:
        ValueError: where the length is negative, or speed or acceleration is not positive, or one is not finite.
    """

    length: float
    speed: float
    acceleration: float
    peak_speed: float = field(init=False)
    ramp: float = field(init=False)
    duration: float = field(init=False)

    def __post_init__(self) -> None:
        if not 0.0 <= self.length < inf:
            raise ValueError(f"length = {self.length} must not be negative and must be finite")
        for name, value in (("speed", self.speed), ("acceleration", self.acceleration)):
            if not 0.0 < value < inf:
                raise ValueError(f"{name} = {value} must be positive and finite")
        peak = min(self.speed, sqrt(self.length * self.acceleration / _PEAK))
        ramp = _PEAK * peak / self.acceleration
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
            return self._ramp(time)
        if left < self.ramp:
            position, speed, acceleration = self._ramp(left)
            return self.length - position, speed, -acceleration
        return self.peak_speed * (time - 0.5 * self.ramp), self.peak_speed, 0.0

    def _ramp(self, time: float) -> tuple[float, float, float]:
        u = time / self.ramp
        position = self.peak_speed * self.ramp * u**3 * (1.0 - 0.5 * u)
        return position, self.peak_speed * u * u * (3.0 - 2.0 * u), self.peak_speed / self.ramp * 6.0 * u * (1.0 - u)
