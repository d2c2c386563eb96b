"""Approach: a straight line in free space, then down until the surface pushes back."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..trajectories.line_chain import LineChain
from ..trajectories.straight_line import StraightLine
from ..types import Pose
from .active_path import OVERTIME, ActivePath
from .primitive import NO_FORCE, Ending, PrimitiveInput, Setpoint

SEARCH_DEPTH = 0.05
"""How far below the expected surface the descent goes on before it gives up [m]."""


@dataclass(frozen=True, slots=True)
class Approach:
    """Move to `pre_grasp`, then down until the normal force exceeds `touch_force`.

    Attributes:
        pre_grasp: tool pose above the place of touch-down.
        height: of the pre-grasp pose above the surface [m].
        speed: of the free-space line [m/s].
        touch_speed: of the descent [m/s].
        touch_force: normal force relative to the primitive's start [N].
        closure: preshape of the hand.
    """

    pre_grasp: Pose
    height: float
    speed: float
    touch_speed: float
    touch_force: float
    closure: float
    name: str = "approach"
    tares: ClassVar[bool] = True

    def begin(self, inputs: PrimitiveInput, last: Setpoint) -> ActiveApproach:
        """Start from the last reference pose."""
        start = last.reference.pose
        across = StraightLine(start, self.pre_grasp.translation - start.translation, self.speed)
        down = StraightLine(across.end, np.array([0.0, 0.0, -(self.height + SEARCH_DEPTH)]), self.touch_speed)
        return ActiveApproach(inputs, LineChain((across, down)), self.closure, NO_FORCE, self)


@dataclass(frozen=True, slots=True, eq=False)
class ActiveApproach(ActivePath):
    """An approach under way."""

    plan: Approach

    def force(self, inputs: PrimitiveInput) -> float:
        """Return the surface's normal force."""
        return float(self.change(inputs)[2])

    def ending(self, inputs: PrimitiveInput) -> Ending | None:
        """End at the surface; a contact before the descent is a collision."""
        elapsed = self.elapsed(inputs)
        if elapsed < self.path.lines[0].duration:
            blow = np.linalg.norm(self.change(inputs))
            return Ending("collision in free space", failed=True) if blow > 5.0 * self.plan.touch_force else None
        if self.force(inputs) > self.plan.touch_force:
            return Ending("surface contact")
        if elapsed > self.path.duration + OVERTIME:
            return Ending("travel limit: no surface", failed=True)
        return None
