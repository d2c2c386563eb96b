"""What primitives have in common that follow lines."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

from ..trajectories.line_chain import LineChain
from ..types import Array
from .primitive import PrimitiveInput, Setpoint

OVERTIME = 0.5
"""A primitive that waits for an event goes on for this long after its path has ended [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class ActivePath:
    """A primitive under way along straight lines.

    Attributes:
        start: what was inputs when it began.
        path: of the tool.
        closure: of the hand.
        desired_force: (6,) that the hand should exert on the environment [N, N·m].
    """

    start: PrimitiveInput
    path: LineChain
    closure: float
    desired_force: Array

    def elapsed(self, inputs: PrimitiveInput) -> float:
        """Return the time since the primitive began [s]."""
        return inputs.time - self.start.time

    def change(self, inputs: PrimitiveInput) -> Array:
        """Return how the force on the hand (3,) has changed since the primitive began [N]."""
        return inputs.wrench[:3] - self.start.wrench[:3]

    def setpoint(self, inputs: PrimitiveInput) -> Setpoint:
        """Return the point on the path."""
        return Setpoint(self.path.at(self.elapsed(inputs)), self.closure, self.desired_force)

    def force(self, inputs: PrimitiveInput) -> float:
        """Return the size of the change of force [N]."""
        change = self.change(inputs)
        return sqrt(change.dot(change))
