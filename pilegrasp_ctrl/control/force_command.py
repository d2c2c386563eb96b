"""The commanded force: the desired force, ramped up and down, and corrected by the measured one."""

from __future__ import annotations

from math import inf, sqrt

import numpy as np

from ..kernels.algebra import length_square
from ..types import Array

_IN_CONTACT = 0.1
"""Share of the desired force above which the hand counts as in contact; chosen."""


class ForceRamp:
    """Ramps a desired force up and down, and limits its rate if it changes in between.

    The share runs from 0 to 1 as `3 u² - 2 u³`, with u linear over `duration`. Within a period h it changes by at most
    `1.5 h / duration`. The force changes by at most `2.5 h / duration` times the largest desired force.

    The ramp remembers its progress. Time that goes backwards starts a new attempt, and the ramp starts at zero.

    Attributes:
        duration: Duration of the ramp [s]; zero switches at once.
        share: Share of the force that is commanded, 0 to 1.
    """

    def __init__(self, duration: float) -> None:
        """Start without a force."""
        self.duration = duration
        self.share = 0.0
        self._time, self._progress, self._force = inf, 0.0, np.zeros(6)

    def update(self, time: float, wanted: Array) -> Array:
        """Return (6,) the force to command now [N, N·m].

        Args:
            time: Time of the observation [s].
            wanted: (6,) Desired force, zeros for none [N, N·m].
        """
        elapsed = time - self._time
        self._time = time
        if elapsed < 0.0:
            self.share, self._progress, elapsed = 0.0, 0.0, 0.0
        on = bool(wanted.any())
        if self._progress == on and (not on or wanted is self._force):
            return wanted
        if self.duration <= 0.0:
            self.share = self._progress = float(on)
            return wanted
        step = elapsed / self.duration
        if on:
            # At a share of zero the force has no effect yet, so it may jump.
            self._force = wanted if self._progress == 0.0 else _limit_change(self._force, wanted, step)
        self._progress = min(max(self._progress + (step if on else -step), 0.0), 1.0)
        self.share = self._progress**2 * (3.0 - 2.0 * self._progress)
        return self.share * self._force


class ForceFeedback:
    """Adds the integral of the force error along the desired force to that force.

        correction = gain ∫ (|F| - pressed) dt,      -|F| <= correction <= |F|

    `pressed` is the measured force against the direction of F. The feedback compensates the force that joint
    friction removes or adds. The bounds prevent windup behind a force that cannot be reached, and keep the hand from
    pulling. Out of contact the correction decays at the rate of the gain, so a hand in the air does not gather speed
    for its next contact. `largest_force_gain` gives the largest gain for a sensor's lag. Torques are not corrected.

    The feedback remembers the correction. Time that goes backwards starts a new attempt and resets it.

    Attributes:
        gain: Integral gain [1/s].
        correction: Correction of the force [N].
    """

    def __init__(self, gain: float) -> None:
        """Start without a correction."""
        self.gain = gain
        self.correction = 0.0
        self._time = inf

    def update(self, time: float, desired: Array, wrench: Array) -> Array:
        """Return (6,) the desired force with its correction [N, N·m].

        Args:
            time: Time of the observation [s].
            desired: (6,) Wrench that the hand should exert on the environment, world axes [N, N·m].
            wrench: (6,) Wrench of the environment on the hand, world axes [N, N·m].
        """
        elapsed = time - self._time
        self._time = time
        if elapsed < 0.0:
            self.correction = 0.0
            elapsed = 0.0
        force = desired[:3]
        size = sqrt(length_square(force))
        if size == 0.0:
            self.correction = 0.0
            return desired
        pressed = -(force[0] * wrench[0] + force[1] * wrench[1] + force[2] * wrench[2]) / size
        error = size - pressed if pressed > _IN_CONTACT * size else -self.correction
        self.correction = min(max(self.correction + self.gain * elapsed * error, -size), size)
        corrected = desired.copy()
        corrected[:3] *= 1.0 + self.correction / size
        return corrected


def _limit_change(force: Array, wanted: Array, share: float) -> Array:
    """Return `force`, moved toward `wanted` by at most `share` times the larger of the two."""
    change = wanted - force
    distance = sqrt(length_square(change))
    largest = share * sqrt(max(length_square(force), length_square(wanted)))
    return wanted if distance <= largest else force + (largest / distance) * change
