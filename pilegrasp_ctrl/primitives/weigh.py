"""Weigh: hold still, and read the vertical force at the wrist."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from ..trajectories.straight_line import LineChain, StraightLine
from .primitive import NO_FORCE, ActivePath, Ending, PrimitiveInput, Setpoint

REST_TIME = 0.2
"""Time at rest before the force counts [s]; chosen, ten times the sensor's time constant."""

WEIGHING_TIME = 0.5
"""Time over which the force is averaged [s]; chosen: noise of 0.1 N becomes 0.01 N."""


@dataclass(frozen=True, slots=True, eq=False)
class Weigh:
    """Stay at the last reference pose, and tell the mean vertical force of the environment on the hand.

    Attributes:
        tell: Function that gets the mean force [N], positive upwards: a load makes it smaller.
    """

    tell: Callable[[float], None]
    name: str = "weigh"
    tares: ClassVar[bool] = True

    def begin(self, inputs: PrimitiveInput, last: Setpoint) -> ActiveWeigh:
        """Stay, with the hand as it is."""
        rest = StraightLine(last.reference.pose, np.zeros(3), 1.0)
        return ActiveWeigh(inputs, LineChain((rest,)), last.closure, NO_FORCE, self)


@dataclass(frozen=True, slots=True, eq=False)
class ActiveWeigh(ActivePath):
    """A weighing that has begun."""

    plan: Weigh
    readings: list[float] = field(default_factory=list)

    def setpoint(self, inputs: PrimitiveInput) -> Setpoint:
        """Read the force, and stay."""
        if self.elapsed(inputs) >= REST_TIME:
            self.readings.append(float(inputs.wrench[2]))
        return ActivePath.setpoint(self, inputs)

    def ending(self, inputs: PrimitiveInput) -> Ending | None:
        """End after the time; tell the mean."""
        if self.elapsed(inputs) < REST_TIME + WEIGHING_TIME or not self.readings:
            return None
        total = 0.0
        for reading in self.readings:
            total += reading
        self.plan.tell(total / len(self.readings))
        return Ending("weighed")
