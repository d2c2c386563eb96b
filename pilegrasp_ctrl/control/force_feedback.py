"""The measured force corrects the desired one: what joint friction takes away or adds is given back."""

from __future__ import annotations

from math import inf, sqrt

from ..types import Array

_IN_CONTACT = 0.1
"""Share of the desired force that must be felt for the hand to count as in contact."""


class ForceFeedback:
    """Integral of the force error along the desired force, added to it.

        correction = gain ∫ (|F| - pressed) dt,      -|F| <= correction <= |F|

    with `pressed` what the sensor feels against the direction of F. The bounds keep the correction from winding up
    behind a force that cannot be had, and the hand from ever pulling. Out of contact the correction decays at the rate
    of the gain, so that a hand in the air does not gather speed for its next contact. `largest_force_gain` says how
    large the gain may be for a sensor's lag. Torques are not corrected.

    Remembers the correction; time that goes backwards is a new attempt and starts from nothing.

    Attributes:
        gain: [1/s].
        correction: [N].
    """

    def __init__(self, gain: float) -> None:
        """Start without a correction."""
        self.gain = gain
        self.correction = 0.0
        self._time = inf

    def update(self, time: float, desired: Array, wrench: Array) -> Array:
        """Return (6,) the desired force with its correction [N, N·m].

        Args:
            time: of the observation [s].
            desired: (6,) what the hand shall exert on the environment, world axes [N, N·m].
            wrench: (6,) what the environment does to the hand, world axes [N, N·m].
        """
        passed = time - self._time
        self._time = time
        if passed < 0.0:
            self.correction = 0.0
            passed = 0.0
        force = desired[:3]
        size = sqrt(force.dot(force))
        if size == 0.0:
            self.correction = 0.0
            return desired
        pressed = -float(force.dot(wrench[:3])) / size
        error = size - pressed if pressed > _IN_CONTACT * size else -self.correction
        self.correction = min(max(self.correction + self.gain * passed * error, -size), size)
        corrected = desired.copy()
        corrected[:3] *= 1.0 + self.correction / size
        return corrected
