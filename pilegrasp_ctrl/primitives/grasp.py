"""Grasp: close the fingers while the hand keeps its pressure on the pile."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..types import Array, Pose, Reference
from .primitive import Ending, PrimitiveInput, Setpoint


@dataclass(frozen=True, slots=True, eq=False)
class Grasp:
    """Close for `duration`, and go on along the push at a speed that falls to zero as the force reaches F_grasp.

    The authors' arm keeps the pressure by being soft: at 17 N its reference is some 0.1 m ahead of it and stays there
    while the fingers curl and give way. A stiffer arm has to follow.

    Attributes:
        duration: of the closing [s].
        direction: (3,) of the push, a unit vector in the world.
        speed: |v_hand| of the push [m/s].
        grasp_force: F_grasp [N].
        advance: farthest that the reference goes on [m].
    """

    duration: float
    direction: Array
    speed: float
    grasp_force: float
    advance: float
    name: str = "grasp"
    tares: ClassVar[bool] = False

    def begin(self, inputs: PrimitiveInput, last: Setpoint) -> ActiveGrasp:
        """Start from the last reference pose, at F_grasp."""
        return ActiveGrasp(self, inputs, last.reference.pose)


@dataclass(slots=True, eq=False)
class ActiveGrasp:
    """A grasp under way; remembers how far it has advanced."""

    plan: Grasp
    start: PrimitiveInput
    here: Pose
    _advanced: float = 0.0
    _time: float | None = None

    def setpoint(self, inputs: PrimitiveInput) -> Setpoint:
        """Advance by the time that has passed since the last call, the hand closed."""
        plan = self.plan
        speed = plan.speed * float(np.clip(1.0 - self.pressure(inputs) / plan.grasp_force, -1.0, 1.0))
        wanted = self._advanced + speed * (inputs.time - (self.start.time if self._time is None else self._time))
        self._time = inputs.time
        self._advanced = float(np.clip(wanted, -plan.advance, plan.advance))
        moving = self._advanced == wanted
        twist = np.concatenate([moving * speed * plan.direction, np.zeros(3)])
        return Setpoint(Reference(self.here.moved(self._advanced * plan.direction), twist), 1.0)

    def pressure(self, inputs: PrimitiveInput) -> float:
        """Return the force against the push [N]; it was F_grasp when the grasp began."""
        change = self.plan.direction @ (inputs.wrench[:3] - self.start.wrench[:3])
        return self.plan.grasp_force - float(change)

    def force(self, inputs: PrimitiveInput) -> float:
        """Return how much the force on the hand has changed."""
        return float(np.linalg.norm(inputs.wrench[:3] - self.start.wrench[:3]))

    def ending(self, inputs: PrimitiveInput) -> Ending | None:
        """End when the closing has had its time; the hand has no sensor that could tell more."""
        return Ending("closed") if inputs.time - self.start.time >= self.plan.duration else None
