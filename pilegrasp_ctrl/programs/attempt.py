"""Preparation of an attempt: settle the pile, plan the motion, and check its poses before anything moves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..arm.model import ArmModel
from ..config import Scenario
from ..exceptions import ConfigurationError, UnreachablePoseError
from ..planning.hand_use import HandUse
from ..planning.layout import REACH, Layout, make_layout
from ..planning.push_goal import PushGoal
from ..planning.push_line import PushLine, plan_push_line
from ..planning.strategy import Plan, plan_attempt, plan_line
from ..robots import names
from ..sim.backend import Simulation
from ..sim.hand import Hand
from ..sim.monitors import RimCheck
from ..sim.objects import Objects, objects_of
from ..sim.pile import Pile, settle_pile
from ..sim.scene import build_scene
from ..sim.start_posture import StartPosture
from ..sim.wrist_sensor import WristSensor
from ..types import Array, Pose
from .controller import Control, ControllerFactory, controller_factory
from .pick_order import PickOrder, delivery_pose


@dataclass(frozen=True, eq=False)
class Attempt:
    """An attempt that is ready to run.

    Attributes:
        scenario: Scenario of the attempt.
        seed: Seed of pile and sensor noise.
        arm: Arm with the known mass of the hand, tool frame and base.
        transform_known_to_scene: Transform from the frame of arm and plan to the frame of the simulation. It is the
            identity unless the true slope of the floor differs from the known one.
        plan: Start pose and primitives.
        simulation: Simulation at the start posture, with the settled pile.
        control: Function from observation and setpoint to torque.
        period: Control period [s].
        pile: Pile as it settled.
        rims: Monitor of the bin's rims.
        order: Pick order; None for other programs than "order".
    """

    scenario: Scenario
    seed: int
    arm: ArmModel
    transform_known_to_scene: Pose
    plan: Plan
    simulation: Simulation
    control: Control
    period: float
    pile: Pile
    rims: RimCheck
    order: PickOrder | None = None


class _Parts(NamedTuple):
    """Parts of an attempt that do not depend on the settled pile.

    Attributes:
        steps: Physics steps in a control period.
        hand: Hand.
        objects: Model of the objects.
        layout: Layout with the known slope of the floor.
        make_controller: Function that makes the controller.
    """

    steps: int
    hand: Hand
    objects: Objects
    layout: Layout
    make_controller: ControllerFactory


def prepare(scenario: Scenario, seed: int) -> Attempt:
    """Settle the pile, plan, check that every pose is within reach, and build the scene.

    Raises:
        PilegraspError: A name, file or key of the scenario is invalid, the pile does not settle, or a pose is out of
            reach.
    """
    steps, hand, objects, layout, make_controller = _parts(scenario)
    slope_error = np.radians(scenario.support.slope_error_deg)
    numerics = scenario.sim.contact_rule, scenario.sim.timestep
    pile = settle_pile(objects, scenario.pile.count, layout.with_rising_floor(slope_error), seed, *numerics)
    goal = layout.goals[0] if layout.goals else None

    def push_line(poses: Array, goal: PushGoal | None) -> PushLine:
        cylinders, radius = objects.shape == "cylinder", objects.bounding_radius
        return plan_push_line(scenario.strategy, hand.use, layout, poses, radius, cylinders=cylinders, goal=goal)

    if scenario.program != "line" and goal is None:
        line = push_line(pile.poses, None)
        layout = layout.with_base_behind_push(line.touch(scenario.strategy), line.point, pile.poses[:, :2])
    tool = hand.mass_properties()
    base = layout.transform_base_to_world
    arm = ArmModel.load(
        scenario.robot, tool=tool, tool_frame=hand.transform_tool_to_flange, base=base, gravity=layout.gravity
    )
    search = StartPosture(scenario.robot, hand.transform_tool_to_flange, base)

    def plan_to(poses: Array, goal: PushGoal | None, posture: Array | None = None) -> tuple[Plan, Array]:
        return _plan_within_reach(scenario, hand.use, layout, push_line(poses, goal), search, posture)

    order = None
    if scenario.program == "order":
        members = objects.net.members if objects.net else 1
        order = PickOrder(scenario, layout.goals, members, delivery_pose(hand.theta), plan_to)
        _, plan, q = order.next_plan(pile.poses)
        search.solve(delivery_pose(hand.theta), q)
    else:
        plan, q = plan_to(pile.poses, goal)
    # The plan is made for the known floor and runs on the true floor.
    true_layout = layout.with_rising_floor(slope_error)
    known_to_scene = true_layout.transform_from(layout)
    scene = build_scene(scenario, hand, objects, true_layout)
    period = steps * scenario.sim.timestep
    sensor = WristSensor(scene.model, tool, scenario.sensor, period, seed, known_to_scene.rotation.T)
    simulation = Simulation(scene, sensor, steps)
    simulation.reset(q, pile.poses)
    return Attempt(
        scenario=scenario,
        seed=seed,
        arm=arm,
        transform_known_to_scene=known_to_scene,
        plan=plan,
        simulation=simulation,
        control=make_controller(arm, q),
        period=period,
        pile=pile,
        rims=RimCheck(scene, layout.walls),
        order=order,
    )


def check(scenario: Scenario) -> None:
    """Check a scenario without its pile: names, files, gains, and combinations of keys.

    Raises:
        ConfigurationError: A name, file or gain is invalid, or two keys exclude one another.
    """
    _parts(scenario)


def _parts(scenario: Scenario) -> _Parts:
    """Return the checked parts of an attempt that do not depend on the settled pile."""
    if scenario.robot not in names():
        raise ConfigurationError(f"robot = {scenario.robot!r} is not known; choose from {', '.join(names())}")
    steps = _steps(scenario)
    hand = Hand.load(scenario.hand, scenario.hand_model)
    objects = objects_of(scenario.pile)
    layout = make_layout(scenario.support, scenario.pile, objects.diameter, scenario.program == "order")
    if scenario.strategy.kind == "object" and (scenario.pile.count == 0 or scenario.support.bin):
        why = "the goal in a bin fixes the push line" if scenario.support.bin else "pile.count is 0"
        raise ConfigurationError(f"strategy.kind = 'object' cannot aim at an object, because {why}; make it 'pile'")
    return _Parts(steps, hand, objects, layout, controller_factory(scenario, hand))


def _steps(scenario: Scenario) -> int:
    """Return the physics steps in a control period."""
    ratio = 1.0 / (scenario.controller.rate * scenario.sim.timestep)
    if abs(ratio - round(ratio)) > 1e-6 or ratio < 0.5:
        raise ConfigurationError(
            f"controller.rate = {scenario.controller.rate:g} Hz does not fit sim.timestep = "
            f"{scenario.sim.timestep:g} s; a control period must be a whole number of physics steps, "
            f"as at {1.0 / (max(1, round(ratio)) * scenario.sim.timestep):.9g} Hz"
        )
    return round(ratio)


def _plan_within_reach(
    scenario: Scenario,
    hand: HandUse,
    layout: Layout,
    line: PushLine,
    search: StartPosture,
    posture: Array | None,
) -> tuple[Plan, Array]:
    """Return the plan with the longest push whose end is within reach, and the start posture."""
    for farthest in REACH:
        plan = _plan(scenario, hand, layout, line, farthest)
        q = posture = search.solve(plan.start, posture)
        for pose in plan.waypoints:
            posture = search.solve(pose, posture)
        try:
            search.solve_near(plan.end, posture)
        except UnreachablePoseError:
            if farthest == REACH[-1]:
                raise
            continue
        break
    return plan, q


def _plan(scenario: Scenario, hand: HandUse, layout: Layout, line: PushLine, farthest: float) -> Plan:
    if scenario.program == "line":
        return plan_line(scenario.line, hand)
    return plan_attempt(
        scenario.strategy,
        hand,
        line.point,
        line.extent,
        farthest,
        grasp=scenario.program != "push",
        yaw=line.yaw,
        base_position=np.array(layout.base_position),
    )
