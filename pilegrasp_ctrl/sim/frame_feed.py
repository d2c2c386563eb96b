"""Shows a simulation to somebody while it runs."""

from __future__ import annotations

import math
from collections.abc import Callable
from time import perf_counter

from ..recording import Body
from ..types import Array
from .backend import Simulation
from .drawing import drawn_bodies

PERIOD = 1.0 / 30.0
"""Simulated time between two frames [s], that of a recording."""

Observer = Callable[[float, str, tuple[Body, ...], Array, Array], None]
"""Called with the time [s], the primitive's name, the B bodies that can be drawn, which are the same at every call,
their positions (B, 3) [m] and their quaternions (B, 4) wxyz, body to scene."""


class FrameFeed:
    """Hands the bodies' poses to an observer at 30 Hz of simulated time.

    Attributes:
        seconds: on the wall clock that the observer took so far.
    """

    def __init__(self, simulation: Simulation, on_frame: Observer) -> None:
        self._simulation, self._on_frame = simulation, on_frame
        self._bodies, self._ids = drawn_bodies(simulation.scene)
        self._next = 0.0
        self.seconds = 0.0

    def show(self, time: float, primitive: str, *, always: bool = False) -> None:
        """Show copies of the poses at `time` [s], if it is its turn or `always`."""
        if time < self._next - 1e-9 and not always:
            return
        self._next = PERIOD * math.floor(time / PERIOD + 1.0 + 1e-6)
        begun = perf_counter()
        self._on_frame(time, primitive, self._bodies, *self._simulation.poses(self._ids))
        self.seconds += perf_counter() - begun
