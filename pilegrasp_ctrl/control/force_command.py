"""The force that is asked for: the desired one, faded in and out, and corrected by the measured one."""

from __future__ import annotations

from math import inf, sqrt

import numpy as np

from ..types import Array

_IN_CONTACT = 0.1
"""Share of the desired force that must be felt for the hand to count as in contact."""


class ForceRamp:
    """Fades a desired force in and out, and slews it where it changes in between.

    The share runs from 0 to 1 as `3 u² - 2 u³`, u linear over `duration`. So within a period h it changes by at most
    `1.5 h / duration`, and the force by at most `2.5 h / duration` times the largest force that was asked for.

    Remembers where it is; time that goes backwards is a new attempt and starts from nothing.

    Attributes:
        duration: [s]; zero switches at once.
        share: how far it has got, 0 to 1.
    """

    def __init__(self, duration: float) -> None:
        """Start without a force."""
        self.duration = duration
        self.share = 0.0
        self._time, self._progress, self._force = inf, 0.0, np.zeros(6)

    def update(self, time: float, wanted: Array) -> Array:
        """Return (6,) the force to ask for now [N, N·m].

        Args:
            time: of the observation [s].
            wanted: (6,) the desired force, zeros for none [N, N·m].
        """
        passed = time - self._time
        self._time = time
        if passed < 0.0:
            self.share, self._progress, passed = 0.0, 0.0, 0.0
        on = bool(wanted.any())
        if self._progress == on and (not on or wanted is self._force):
            return wanted
        if self.duration <= 0.0:
            self.share = self._progress = float(on)
            return wanted
        step = passed / self.duration
        if on:
            # Nothing is felt of a force while its share is zero.
            self._force = wanted if self._progress == 0.0 else _slewed(self._force, wanted, step)
        self._progress = min(max(self._progress + (step if on else -step), 0.0), 1.0)
        self.share = self._progress**2 * (3.0 - 2.0 * self._progress)
        return self.share * self._force


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


def _slewed(force: Array, wanted: Array, share: float) -> Array:
    """Return `force` moved toward `wanted` by at most `share` of the larger of the two."""
    change = wanted - force
    distance = float(np.sqrt(change.dot(change)))
    largest = share * float(np.sqrt(max(force.dot(force), wanted.dot(wanted))))
    return wanted if distance <= largest else force + (largest / distance) * change
