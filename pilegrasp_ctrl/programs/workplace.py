"""The workplace of a program: scenario, hand, layout and settled pile, and plans that are within reach there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

from ..arm.model import ArmModel
from ..config import Scenario
from ..exceptions import UnreachablePoseError
from ..planning.layout import Layout
from ..planning.push_goal import PushGoal
from ..planning.push_line import PushLine, plan_push_line
from ..planning.strategy import Plan
from ..sections import KnownConfig
from ..sim.hand import Hand
from ..sim.objects import Objects
from ..sim.simulation import Simulation
from ..sim.start_posture import StartPosture
from ..types import Array
from .controller import Control


class Station(NamedTuple):
    """An arm with its hand in a scene, ready to be controlled.

    Attributes:
        arm: Arm with the known mass of the hand, tool frame and base.
        simulation: Simulation with arm and objects at rest.
        control: Function from observation and setpoint to torque.
    """

    arm: ArmModel
    simulation: Simulation
    control: Control


@dataclass(frozen=True, eq=False)
class Workplace:
    """A settled pile, and who shall work at it.

    Attributes:
        scenario: Scenario of the attempt.
        hand: Hand.
        objects: Model of the objects.
        layout: Layout as it is known, with the arm's base in its place.
        poses: (n, 7) poses of the objects as they are known: position [m] and quaternion wxyz.
        search: Search for the joint angles of a pose.
        make_station: Function that makes arm, scene and controller for a workplace, a posture (nv,) [rad] and the true
            poses (n, 7) of the objects.
        seed: Seed of the attempt.
    """

    scenario: Scenario
    hand: Hand
    objects: Objects
    layout: Layout
    poses: Array
    search: StartPosture
    make_station: Callable[[Workplace, Array, Array], Station]
    seed: int = 0

    def with_hand(self, hand: Hand, poses: Array) -> Workplace:
        """Return the workplace with another hand on the same arm, and objects at other known `poses` (n, 7)."""
        base = self.layout.transform_base_to_world
        search = StartPosture(self.scenario.robot, hand.transform_tool_to_flange, base)
        return replace(self, hand=hand, poses=poses, search=search)

    @property
    def goal(self) -> PushGoal | None:
        """The scenario's own push goal in a bin; None outside a bin."""
        return self.layout.goals[0] if self.layout.goals else None

    def push_line(self, poses: Array, goal: PushGoal | None) -> PushLine:
        """Return the line of a push to objects at `poses` (n, 7), or to a goal in a bin."""
        return push_line(self.scenario, self.hand, self.objects, self.layout, poses, goal)

    def within_reach(self, make_plan: Callable[[float], Plan], posture: Array | None = None) -> tuple[Plan, Array]:
        """Return the plan with the longest push whose end is within reach, and the start posture (nv,) [rad].

        Args:
            make_plan: Function from the farthest fingertip distance from the arm's axis [m] to a plan.
            posture: (nv,) joint angles from which the search begins [rad].

        Raises:
            UnreachablePoseError: A pose is out of reach.
        """
        reach = self.layout.room.reach
        for farthest in reach:
            plan = make_plan(farthest)
            q = posture = self.search.solve(plan.start, posture)
            for pose in plan.waypoints:
                posture = self.search.solve(pose, posture)
            try:
                self.search.solve_near(plan.end, posture)
            except UnreachablePoseError:
                if farthest == reach[-1]:
                    raise
                continue
            break
        return plan, q


def believed_poses(known: KnownConfig, poses: Array) -> Array:
    """Return the poses (n, 7) of objects as the arm believes them."""
    if (known.pile_x, known.pile_y) == (0.0, 0.0):
        return poses
    believed = poses.copy()
    believed[:, :2] += (known.pile_x, known.pile_y)
    return believed


def push_line(
    scenario: Scenario, hand: Hand, objects: Objects, layout: Layout, poses: Array, goal: PushGoal | None
) -> PushLine:
    """Return the line of a push before the arm's base has its place; see `Workplace.push_line`."""
    cylinders, radius = objects.shape == "cylinder", objects.bounding_radius
    return plan_push_line(scenario.strategy, hand.use, layout, poses, radius, cylinders=cylinders, goal=goal)
