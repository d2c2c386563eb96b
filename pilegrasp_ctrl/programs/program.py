"""The interface of a program: it plans at a workplace, runs in the loop of an attempt, and judges the end."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

from ..analysis.kept_objects import NOTHING_HELD
from ..planning.strategy import Plan
from ..primitives.primitive import Primitive
from ..primitives.retry import Composite
from ..types import Array, Outcome, Pose
from .operator import BinState
from .pick_order import PickAttempt
from .workplace import Station, Workplace


class Verdict(NamedTuple):
    """How an attempt ended.

    Attributes:
        outcomes: Outcomes of all primitives that began.
        grasped: Number of objects held, or delivered.
        reason: Reason of a failure; None after a success.
    """

    outcomes: list[Outcome]
    grasped: int
    reason: str | None


class Runner(Protocol):
    """What the loop of an attempt offers a program."""

    def run_primitives(self, primitives: Sequence[Primitive | Composite], retreating: bool = False) -> list[Outcome]:
        """Run primitives until one fails; `retreating` ignores rims, the saturated sensor and the time limit."""

    def begin(self, plan: Plan) -> None:
        """Prepare for another attempt of the same arm: its time limit, and the sensor's zero."""

    def state(self) -> BinState:
        """Return the present state of objects and arm."""

    def tool(self) -> Pose:
        """Return the present pose of the tool as the arm knows it."""

    def exchange(self, station: Station, plan: Plan) -> None:
        """Go on with another station, at rest at the start of `plan`; hold there until fingers and sensor have settled.

        Raises:
            ConfigurationError: The attempt does not run in its own simulation.
        """

    def count_held(self, lift_height: float) -> int:
        """Return the number of objects that have come up with the hand, for a lift of `lift_height` [m]."""


class Course(Protocol):
    """A program that has been planned for a pile; it runs once."""

    @property
    def plan(self) -> Plan:
        """First plan."""

    @property
    def posture(self) -> Array:
        """(nv,) joint angles at its start [rad]."""

    @property
    def attempts(self) -> Sequence[PickAttempt]:
        """Attempts of an order so far; empty for other programs."""

    def run(self, loop: Runner) -> Verdict:
        """Run in the loop until everything is done, or something fails."""


class Program(Protocol):
    """What an attempt does with a pile."""

    def begin(self, workplace: Workplace) -> Course:
        """Plan for a settled pile.

        Raises:
            UnreachablePoseError: A pose is out of reach.
        """


class SingleCourse:
    """The course of one plan, which runs once: its primitives in their order."""

    attempts: Sequence[PickAttempt] = ()

    def __init__(self, plan: Plan, posture: Array, lift_height: float) -> None:
        """Take the plan, the posture at its start (nv,) [rad], and the height of its lift [m]."""
        self.plan, self.posture, self._lift_height = plan, posture, lift_height

    def run(self, loop: Runner) -> Verdict:
        """Run the primitives; if the plan grasps, an object must be in the hand at the end."""
        outcomes = loop.run_primitives(self.plan.primitives)
        if outcomes[-1].status == "failed":
            return Verdict(outcomes, 0, f"{outcomes[-1].name}: {outcomes[-1].trigger}")
        if not self.plan.grasps:
            return Verdict(outcomes, 0, None)
        grasped = loop.count_held(self._lift_height)
        return Verdict(outcomes, grasped, None if grasped else NOTHING_HELD)
