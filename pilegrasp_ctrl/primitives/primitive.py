"""The interface of a primitive: it begins from its inputs, gives setpoints, and ends by an event."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import ClassVar, NamedTuple, Protocol

import numpy as np

from ..trajectories.straight_line import LineChain
from ..types import Array, Pose, Reference

NO_FORCE = np.zeros(6)
"""Desired force of a hand that need not press on anything [N, N·m]."""
NO_FORCE.setflags(write=False)

UP = np.array([0.0, 0.0, 1.0])
"""Unit vector away from the floor."""

OVERTIME = 0.5
"""Time for which a primitive still waits for its event after its path has ended [s]; chosen."""


class PrimitiveInput(NamedTuple):
    """What a primitive may use: the clock, the arm's own kinematics and the wrist sensor.

    Attributes:
        time: Time [s].
        pose: Pose of the tool frame in the world, from the joint angles.
        wrench: (6,) wrench of the environment on the hand, in world axes [N, N·m].
    """

    time: float
    pose: Pose
    wrench: Array


class Setpoint(NamedTuple):
    """What a primitive asks for at one instant.

    Attributes:
        reference: Pose, twist and acceleration of the tool frame.
        closure: Closure of the hand, in [0, 1].
        desired_force: (6,) force that the hand should exert on the environment [N, N·m]. Only impedance control uses
            it.
    """

    reference: Reference
    closure: float
    desired_force: Array = NO_FORCE


@dataclass(frozen=True, slots=True)
class Ending:
    """How a primitive ended.

    Attributes:
        trigger: Event that ended it, or the reason of the failure.
        failed: Whether it failed.
    """

    trigger: str
    failed: bool = False


class ActivePrimitive(Protocol):
    """A primitive that has begun."""

    def setpoint(self, inputs: PrimitiveInput) -> Setpoint:
        """Return the present setpoint. The loop calls this once a control period."""
        ...

    def ending(self, inputs: PrimitiveInput) -> Ending | None:
        """Return how the primitive ended, or None while it goes on."""
        ...

    def force(self, inputs: PrimitiveInput) -> float:
        """Return the force that the primitive watches, relative to its start [N]."""
        ...


class Primitive(Protocol):
    """A primitive that has not begun."""

    tares: ClassVar[bool]
    """Whether the recorded forces are set to zero at its start. Grasp and lift keep the zero of the push."""

    @property
    def name(self) -> str:
        """Name in the outcomes."""
        ...

    def begin(self, inputs: PrimitiveInput, last: Setpoint) -> ActivePrimitive:
        """Start now, and continue from the last setpoint so that the reference never jumps."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class ActivePath:
    """Base of the active primitives that follow straight lines.

    Attributes:
        start: Inputs at the start.
        path: Path of the tool.
        closure: Closure of the hand.
        desired_force: (6,) force that the hand should exert on the environment [N, N·m].
    """

    start: PrimitiveInput
    path: LineChain
    closure: float
    desired_force: Array

    def elapsed(self, inputs: PrimitiveInput) -> float:
        """Return the time since the start [s]."""
        return inputs.time - self.start.time

    def force_change(self, inputs: PrimitiveInput) -> Array:
        """Return how much the force (3,) on the hand has changed since the start [N]."""
        return inputs.wrench[:3] - self.start.wrench[:3]

    def setpoint(self, inputs: PrimitiveInput) -> Setpoint:
        """Return the present point of the path."""
        return Setpoint(self.path.at(self.elapsed(inputs)), self.closure, self.desired_force)

    def force(self, inputs: PrimitiveInput) -> float:
        """Return the magnitude of the force change [N]."""
        change = self.force_change(inputs)
        return sqrt(change.dot(change))


def horizontal_part(rotation: Array) -> Array:
    """Return the horizontal part (3,) of the direction of the fingers; `rotation` (3, 3) is the tool's."""
    return rotation[:, 0] * np.array([1.0, 1.0, 0.0])
