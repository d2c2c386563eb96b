"""The push goals of a scenario's bin: the rule of `planning/bin_goals.py`, asked of arm and hand."""

from __future__ import annotations

import math

import numpy as np

from ..arm.model import ArmModel
from ..config import Scenario
from ..exceptions import ModelError, UnreachablePoseError
from ..limits.collision_limit import CollisionLimit
from ..planning.bin_goals import find_bin_goals
from ..planning.layout import Layout
from ..planning.push_goal import PushGoal
from ..planning.strategy import PRE_GRASP_HEIGHT, START_BACK, tool_rotation
from ..primitives.primitive import UP
from ..robots import folder_digest
from ..sim.hand import Hand
from ..sim.start_posture import StartPosture
from ..types import Array, Pose
from ..vectors import rotated
from .keep_clear import keep_clear

LINK_CLEARANCE = 0.03
"""Clearance of the arm's links and of the sensor to all walls as the hand comes down [m]; chosen. It is larger than the
hand's, because the elbow follows from the posture in which the arm begins."""

SHORT_OF_WALL = 0.08
"""Distance before the end of a push up to which the arm must reach [m]; chosen: the objects between hand and wall."""

_found: dict[str, tuple[PushGoal, ...]] = {}
"""Goals by what they depend on: the search takes one to two seconds, and a study has many attempts in one bin."""


def bin_goals(scenario: Scenario, hand: Hand, layout: Layout) -> tuple[PushGoal, ...]:
    """Return the push goals in the bin of `layout`.

    Raises:
        ConfigurationError: The hand does not fit into the bin, or the bin is out of the arm's reach.
        ModelError: The arm's model cannot be read.
    """
    strategy = scenario.strategy
    angles = strategy.alpha_deg, strategy.beta_deg, strategy.theta_deg
    keys = [each.model_dump_json() for each in (scenario.support, scenario.order)]
    key = repr(
        (folder_digest(scenario.robot), hand.folder, hand.parameters, keys, layout.room, len(layout.walls), angles)
    )
    if key not in _found:
        _found[key] = _find(scenario, hand, layout)
    return _found[key]


def _find(scenario: Scenario, hand: Hand, layout: Layout) -> tuple[PushGoal, ...]:
    """Return the goals; both arguments of the rule follow from the scenario's angles."""
    strategy, use = scenario.strategy, hand.use
    alpha, beta = math.radians(strategy.alpha_deg), math.radians(strategy.beta_deg)
    theta = use.theta if strategy.theta_deg is None else math.radians(strategy.theta_deg)
    reach = _Reach(scenario, hand, layout, beta, theta)

    def outline(yaw: float) -> Array:
        turned = use.outline.copy()
        turned[:, :3] = rotated(tool_rotation(yaw + alpha + beta, theta), turned[:, :3])
        return turned

    if layout.bin is None:
        return ()
    return find_bin_goals(layout.bin, layout.walls, outline, reach.clears, layout.start_height, alpha)


class _Reach:
    """Looks for postures of the arm at the poses of a push, and for its distance to the walls there."""

    def __init__(self, scenario: Scenario, hand: Hand, layout: Layout, beta: float, theta: float) -> None:
        self._beta, self._theta, self._height = beta, theta, layout.start_height
        tool, base = hand.transform_tool_to_flange, layout.transform_base_to_world
        self._arm = ArmModel.load(
            scenario.robot, tool=hand.mass_properties(), tool_frame=tool, base=base, gravity=layout.gravity
        )
        self._search = StartPosture(scenario.robot, tool, base)
        self._limits = _links_and_walls(scenario, self._arm, layout)

    def clears(self, yaw: float, touch: Array, end: Array) -> bool:
        """Return whether the arm reaches touch-down (2,) and end (2,), and its links clear the walls coming down."""
        direction = np.array([math.cos(yaw), math.sin(yaw), 0.0])
        rotation, point = tool_rotation(yaw + self._beta, self._theta), np.array([*touch, 0.0])
        down = (point - START_BACK * direction + self._height * UP, point + PRE_GRASP_HEIGHT * UP, point)
        q: Array | None = None
        try:
            for position in down:
                q = self._search.solve(Pose(position, rotation), q)
                if self._nearest(q) < LINK_CLEARANCE:
                    return False
            far = np.array([*end, 0.0]) - SHORT_OF_WALL * direction
            self._search.solve(Pose(far, rotation), q)
        except UnreachablePoseError:
            return False
        return True

    def _nearest(self, q: Array) -> float:
        """Return the smallest distance of links and sensor to a wall at a posture (nv,) [m]."""
        state = self._arm.update(q, np.zeros(len(q)))
        return min((min(limit.distances(state).values()) for limit in self._limits), default=math.inf)


def _links_and_walls(scenario: Scenario, arm: ArmModel, layout: Layout) -> list[CollisionLimit]:
    """Return the limit that measures links and sensor against walls; none for an arm without collision geometry."""
    try:
        return keep_clear(scenario, arm, layout.walls)[:1]
    except ModelError:
        return []
