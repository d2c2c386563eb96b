"""How fast a distance may shrink, so that there is room to stop, and the acceleration toward its end that follows."""

# mypy: allow-untyped-defs

from __future__ import annotations

from math import sqrt

from .compile import NUMBER, kernel


@kernel(NUMBER, NUMBER, NUMBER, NUMBER, NUMBER)
def allowed_speed(d, braking, gain, retreat):
    """Return the speed phi(d) at which a distance d may shrink.

        phi = gain d                              d <= braking / gain²
              sqrt(2 braking d - (braking/gain)²)    beyond

    Along phi the deceleration is `braking` on the parabola and less on the line, and both join smoothly. Below zero phi
    is negative: the distance must grow, at `retreat` or less.
    """
    knee = braking / (gain * gain)
    if d > knee:
        return sqrt(2.0 * braking * d - braking * knee)
    return max(gain * d, -retreat)


@kernel(NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER)
def approach_acceleration(d, speed, braking, gain, retreat, horizon):
    """Return the largest acceleration toward the end of a distance, for a speed within phi after the horizon T.

    d is the distance after the horizon, and `speed` the speed at which it shrinks then, without acceleration. With an
    acceleration x that is constant over T, the speed becomes `speed + T x` and the distance `d - T² x / 2`. The tangent
    of phi (`allowed_speed`) gives

        speed + T x <= phi(d) - phi'(d) T² x / 2,        x <= (phi - speed) / (T (1 + phi' T / 2))
    """
    allowed = allowed_speed(d, braking, gain, retreat)
    slope = gain
    if d > braking / (gain * gain):
        slope = braking / allowed
    elif gain * d < -retreat:
        slope = 0.0
    return (allowed - speed) / (horizon * (1.0 + 0.5 * slope * horizon))
