"""The interface of a primitive: it begins from its inputs, gives setpoints, and ends by an event."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, NamedTuple, Protocol

import numpy as np

from ..kernels.algebra import distance
from ..kernels.wrist import change_size
from ..trajectories.straight_line import LineChain
from ..types import Array, Pose, Reference
from ..vectors import norm

NO_FORCE = np.zeros(6)
"""Desired wrench (6,) of a hand that need not press on anything [N, N·m]."""
NO_FORCE.setflags(write=False)

UP = np.array([0.0, 0.0, 1.0])
"""Unit vector (3,) of the vertical, upwards."""

OVERTIME = 0.5
"""Time for which a primitive waits for its event after the end of its path [s]; chosen."""


class PrimitiveInput(NamedTuple):
    """The inputs of a primitive: time, the arm's own kinematics and the wrist sensor.

    Attributes:
        time: Time [s].
        pose: Pose of the tool frame in the world, from the joint angles.
        wrench: (6,) Wrench of the environment on the hand, in world axes [N, N·m].
        touched: Number of objects that touch the fingers; 0 for a hand without touch.
        inside: Number of objects that touch a finger behind its tip.
    """

    time: float
    pose: Pose
    wrench: Array
    touched: int = 0
    inside: int = 0


class Setpoint(NamedTuple):
    """The output of a primitive at one instant.

    Attributes:
        reference: Pose, twist and acceleration of the tool frame.
        closure: Closure of the hand, in [0, 1].
        desired_force: (6,) Force that the hand should exert on the environment [N, N·m]. Only impedance control uses
            it.
    """

    reference: Reference
    closure: float
    desired_force: Array = NO_FORCE


@dataclass(frozen=True, slots=True)
class Ending:
    """The end of a primitive.

    Attributes:
        trigger: Event that ended the primitive, or the reason for its failure.
        failed: Whether the primitive failed.
    """

    trigger: str
    failed: bool = False


class ActivePrimitive(Protocol):
    """A primitive that has begun."""

    def setpoint(self, inputs: PrimitiveInput) -> Setpoint:
        """Return the present setpoint. The loop calls this once per control period."""

    def ending(self, inputs: PrimitiveInput) -> Ending | None:
        """Return how the primitive ended, or None while it continues."""

    def force(self, inputs: PrimitiveInput) -> float:
        """Return the force that the primitive monitors, relative to its start [N]."""


class Primitive(Protocol):
    """A primitive that has not begun."""

    tares: ClassVar[bool]
    """Whether the recorded forces are set to zero at its start. Grasp and lift keep the zero of the push."""

    @property
    def name(self) -> str:
        """Name of the primitive in the outcomes."""

    def begin(self, inputs: PrimitiveInput, last: Setpoint) -> ActivePrimitive:
        """Start now, and continue from the last setpoint so that the reference never jumps."""


@dataclass(frozen=True, slots=True, eq=False)
class ActivePath:
    """Base of the active primitives that follow straight lines.

    Attributes:
        start: Inputs at the start.
        path: Path of the tool.
        closure: Closure of the hand.
        desired_force: (6,) Force that the hand should exert on the environment [N, N·m].
    """

    start: PrimitiveInput
    path: LineChain
    closure: float
    desired_force: Array

    def elapsed(self, inputs: PrimitiveInput) -> float:
        """Return the time since the start [s]."""
        return inputs.time - self.start.time

    def distance_to_end(self, inputs: PrimitiveInput) -> float:
        """Return the distance of the tool from the end of the path [m]."""
        return distance(inputs.pose.translation, self.path.end.translation)

    def force_up(self, inputs: PrimitiveInput) -> float:
        """Return the change of the vertical force on the hand since the start [N], positive upwards."""
        return float(inputs.wrench[2] - self.start.wrench[2])

    def setpoint(self, inputs: PrimitiveInput) -> Setpoint:
        """Return the present point of the path."""
        return Setpoint(self.path.at(self.elapsed(inputs)), self.closure, self.desired_force)

    def force(self, inputs: PrimitiveInput) -> float:
        """Return the magnitude of the force change [N]."""
        return change_size(inputs.wrench, self.start.wrench)


def horizontal_direction(rotation: Array) -> Array:
    """Return the unit vector (3,) of the fingers' horizontal part; `rotation` (3, 3) is the orientation of the tool."""
    level = rotation[:, 0] * np.array([1.0, 1.0, 0.0])
    return level / norm(level)
