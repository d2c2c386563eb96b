"""Keep the pressure on the pile while the hand closes or tilts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..types import Array, Reference
from .primitive import Sensed


@dataclass(frozen=True, slots=True, eq=False)
class Pressure:
    """Go on along the push at a speed that falls to zero as the force reaches F_grasp, and back beyond it.

    The authors' arm keeps the pressure by being soft: at 17 N its reference is some 0.1 m ahead of it and stays there
    while the fingers curl and give way. A stiffer arm has to follow.

    Attributes:
        direction: (3,) of the push, a unit vector in the world.
        speed: |v_hand| of the push [m/s].
        grasp_force: F_grasp [N].
        advance: farthest that the reference goes on [m].
    """

    direction: Array
    speed: float
    grasp_force: float
    advance: float


@dataclass(slots=True, eq=False)
class PressureKept:
    """The pressure being kept, from an instant at which it was F_grasp; remembers how far that has led."""

    plan: Pressure
    start: Sensed
    _advanced: float = 0.0
    _time: float | None = None

    def move(self, reference: Reference, sensed: Sensed) -> Reference:
        """Return the reference carried along by the time that has passed since the last call."""
        plan = self.plan
        speed = plan.speed * float(np.clip(1.0 - self.force(sensed) / plan.grasp_force, -1.0, 1.0))
        wanted = self._advanced + speed * (sensed.time - (self.start.time if self._time is None else self._time))
        self._time = sensed.time
        self._advanced = float(np.clip(wanted, -plan.advance, plan.advance))
        moving = self._advanced == wanted
        twist = reference.twist + np.concatenate([moving * speed * plan.direction, np.zeros(3)])
        return Reference(reference.pose.moved(self._advanced * plan.direction), twist, reference.acceleration)

    def force(self, sensed: Sensed) -> float:
        """Return the force against the push [N]."""
        change = self.plan.direction @ (sensed.wrench[:3] - self.start.wrench[:3])
        return self.plan.grasp_force - float(change)
