"""A desired force that is switched on and off without a jump."""

from __future__ import annotations

from math import inf

import numpy as np

from ..types import Array


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


def _slewed(force: Array, wanted: Array, share: float) -> Array:
    """Return `force` moved toward `wanted` by at most `share` of the larger of the two."""
    change = wanted - force
    distance = float(np.sqrt(change.dot(change)))
    largest = share * float(np.sqrt(max(force.dot(force), wanted.dot(wanted))))
    return wanted if distance <= largest else force + (largest / distance) * change
