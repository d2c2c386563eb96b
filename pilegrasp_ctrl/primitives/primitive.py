"""What a primitive is: it begins from its inputs, gives a setpoint at any time, and ends by an event."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, NamedTuple, Protocol

import numpy as np

from ..types import Array, Pose, Reference

NO_FORCE = np.zeros(6)
NO_FORCE.setflags(write=False)


class PrimitiveInput(NamedTuple):
    """What a primitive may look at: the clock, the arm's own kinematics and the wrist sensor.

    Attributes:
        time: [s].
        pose: the tool frame in the world, from the joint angles.
        wrench: (6,) [N, N·m] of the environment on the hand, in world axes.
    """

    time: float
    pose: Pose
    wrench: Array


class Setpoint(NamedTuple):
    """What a primitive asks for at one instant.

    Attributes:
        reference: pose, twist and acceleration of the tool frame.
        closure: of the hand, in [0, 1].
        desired_force: (6,) [N, N·m] that the hand should exert on the environment; impedance control uses it.
    """

    reference: Reference
    closure: float
    desired_force: Array = NO_FORCE


@dataclass(frozen=True, slots=True)
class Ending:
    """How a primitive ended: `failed` or not, and the event or the reason."""

    trigger: str
    failed: bool = False


class ActivePrimitive(Protocol):
    """A primitive that has begun."""

    def setpoint(self, inputs: PrimitiveInput) -> Setpoint:
        """Return what is asked for now; called once a control period."""
        ...

    def ending(self, inputs: PrimitiveInput) -> Ending | None:
        """Return how the primitive ended, or None while it goes on."""
        ...

    def force(self, inputs: PrimitiveInput) -> float:
        """Return the force that the primitive watches, relative to its start [N]."""
        ...


class Primitive(Protocol):
    """A primitive that is waiting for its turn."""

    tares: ClassVar[bool]
    """Whether the recorded forces are set to zero where it begins; grasp and lift go on from the push's zero."""

    @property
    def name(self) -> str:
        """Name as it appears in outcomes."""
        ...

    def begin(self, inputs: PrimitiveInput, last: Setpoint) -> ActivePrimitive:
        """Start at the given instant, continuing from the last setpoint, so that no reference ever jumps."""
        ...
