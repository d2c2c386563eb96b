"""The clock of the live view: it holds the simulation back to real time, and measures how fast it would run."""

from __future__ import annotations

import math
import time
from collections import deque

SPAN = 1.0
"""Simulated time over which the real-time factor is measured [s]; chosen."""


class Pace:
    """Pace of a simulation whose frames are shown at their times."""

    def __init__(self) -> None:
        self._ahead: float | None = None
        self._resumed: float | None = None
        self._steps: deque[tuple[float, float]] = deque()

    def hold(self, moment: float) -> None:
        """Sleep until the wall clock has reached the simulated time `moment` [s].

        Frames of a simulation that is slower than real time do not wait; it does not catch up afterwards.
        """
        now = time.monotonic()
        if self._resumed is not None:
            self._steps.append((moment, now - self._resumed))
        behind = now - moment
        self._ahead = behind if self._ahead is None else max(self._ahead, behind)
        time.sleep(self._ahead - behind)

    def resume(self, moment: float) -> None:
        """Note that the simulation goes on from `moment` [s]; what was before does not count as its time."""
        if self._resumed is None:
            self._steps.append((moment, 0.0))
        self._resumed = time.monotonic()

    def factor(self) -> float | None:
        """Return the real-time factor; None before two frames.

        It is the simulated time of the last `SPAN` over the time that the loop took, without the view's.
        """
        while len(self._steps) > 2 and self._steps[-1][0] - self._steps[1][0] >= SPAN:
            self._steps.popleft()
        if len(self._steps) < 2:
            return None
        simulated = self._steps[-1][0] - self._steps[0][0]
        taken = math.fsum(seconds for _, seconds in list(self._steps)[1:])
        return simulated / taken if taken > 0.0 else None
