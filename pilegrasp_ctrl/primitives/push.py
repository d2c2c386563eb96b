"""Push: slide along the support until the force along the push reaches F_grasp."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..trajectories.line_chain import LineChain
from ..trajectories.straight_line import StraightLine
from ..types import Array
from .active_path import OVERTIME, ActivePath
from .primitive import Ending, PrimitiveInput, Setpoint

SINK_SPEED = 0.04
"""Of the reference on its way to the press depth [m/s]."""


@dataclass(frozen=True, slots=True, eq=False)
class Push:
    """Slide along `direction` at `speed`.

    Attributes:
        direction: (3,) unit vector in the world.
        speed: |v_hand| [m/s].
        grasp_force: F_grasp, along the push, relative to the primitive's start [N].
        travel: longest way [m].
        press_depth: the reference sinks this far below touch-down, so that a soft hand keeps touching [m].
        normal_force: desired force on the support, for a hand that is force-controlled [N].
        closure: preshape of the hand.
    """

    direction: Array
    speed: float
    grasp_force: float
    travel: float
    press_depth: float
    normal_force: float
    closure: float
    name: str = "push"
    tares: ClassVar[bool] = True

    def begin(self, inputs: PrimitiveInput, last: Setpoint) -> ActivePush:
        """Start where the hand touches down, wherever the reference has gone meanwhile."""
        reference = last.reference.pose
        sink = inputs.pose.translation[2] - self.press_depth - reference.translation[2]
        down = StraightLine(reference, np.array([0.0, 0.0, sink]), SINK_SPEED)
        along = StraightLine(down.end, self.travel * np.asarray(self.direction), self.speed)
        desired_force = np.array([0.0, 0.0, -self.normal_force, 0.0, 0.0, 0.0])
        return ActivePush(inputs, LineChain((down, along)), self.closure, desired_force, self)


@dataclass(frozen=True, slots=True, eq=False)
class ActivePush(ActivePath):
    """A push under way."""

    plan: Push

    def force(self, inputs: PrimitiveInput) -> float:
        """Return the force against the push."""
        return float(-self.plan.direction.dot(self.change(inputs)))

    def ending(self, inputs: PrimitiveInput) -> Ending | None:
        """End at F_grasp, or where the travel ends."""
        if self.force(inputs) >= self.plan.grasp_force:
            return Ending("grasp force")
        if self.elapsed(inputs) > self.path.duration + OVERTIME:
            return Ending("travel limit: the force along the push never reached F_grasp", failed=True)
        return None
