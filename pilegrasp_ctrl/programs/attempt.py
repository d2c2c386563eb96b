"""Everything an attempt needs before anything moves; what cannot be done is found out here."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..arm.model import ArmModel
from ..arm.state import ArmState
from ..config import Scenario
from ..control.contact_impedance import ContactImpedanceController
from ..control.operational_space import OperationalSpaceController
from ..control.tool_axes import move_wrench
from ..exceptions import ConfigurationError, UnreachablePoseError
from ..planning.hand_use import HandUse
from ..planning.layout import REACH, Layout, make_layout
from ..planning.push_goal import PushGoal
from ..planning.push_line import PushLine, plan_push_line
from ..planning.strategy import Plan, line_plan, pile_strategy
from ..primitives.primitive import Setpoint
from ..robots import names, path
from ..sim.backend import Simulation
from ..sim.hand import Hand
from ..sim.monitors import RimCheck
from ..sim.objects import Objects, objects_of
from ..sim.pile import Pile, settle_pile
from ..sim.scene import build_scene
from ..sim.start_posture import StartPosture
from ..sim.wrist_sensor import WristSensor
from ..tasks.gains import Impedance, MotionGains, load_gains
from ..types import Array, ControllerOutput, Observation, Pose
from .pick_order import PickOrder, delivery_pose

Control = Callable[[Observation, Setpoint, ArmState], ControllerOutput]


@dataclass(frozen=True, eq=False)
class Attempt:
    """An attempt that is ready to run.

    Attributes:
        scenario: what was asked for.
        seed: of pile and sensor noise.
        arm: the arm with the hand's mass, tool frame and base, as it is known.
        transform_known_to_scene: from the frame in which arm and plan count to that of the simulation; the identity
            unless the floor slopes in another way than is known.
        plan: start pose and primitives.
        simulation: at the start posture, the pile settled.
        control: from observation and setpoint to torque.
        period: of the control [s].
        pile: as it settled.
        rims: watches the walls of a bin.
        order: for `program = "order"`, what comes after the first attempt.
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


def prepare(scenario: Scenario, seed: int) -> Attempt:
    """Settle the pile, plan, check that every pose is within reach, and build the scene.

    Raises:
        PilegraspError: where one of these cannot be done.
    """
    steps, hand, objects, layout, control = _parts(scenario)
    error = np.radians(scenario.support.slope_error_deg)
    numerics = scenario.sim.contact_rule, scenario.sim.timestep
    pile = settle_pile(objects, scenario.pile.count, layout.rising(error), seed, *numerics)
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
    # Planned on the floor as it is known, carried out on the floor as it is.
    true = layout.rising(error)
    known_to_scene = true.transform_from(layout)
    scene = build_scene(scenario, hand, objects, true)
    period = steps * scenario.sim.timestep
    sensor = WristSensor(scene.model, tool, scenario.sensor, period, seed, known_to_scene.rotation.T)
    simulation = Simulation(scene, sensor, steps)
    simulation.reset(q, pile.poses)
    rims = RimCheck(scene, layout.walls)
    return Attempt(scenario, seed, arm, known_to_scene, plan, simulation, control(arm, q), period, pile, rims, order)


def check(scenario: Scenario) -> None:
    """Find out what can be found out without a pile: names, files, gains, and keys that do not go together.

    Raises:
        ConfigurationError: where one of them cannot be used.
    """
    _parts(scenario)


def _parts(scenario: Scenario) -> tuple[int, Hand, Objects, Layout, Callable[[ArmModel, Array], Control]]:
    """Return physics steps in a control period, hand, kind of object, layout, and what makes the controller."""
    if scenario.robot not in names():
        raise ConfigurationError(f"robot = {scenario.robot!r} is not known; choose from {', '.join(names())}")
    steps = _steps(scenario)
    hand = Hand.load(scenario.hand, scenario.hand_model)
    objects = objects_of(scenario.pile)
    layout = make_layout(scenario.support, scenario.pile, objects.diameter, scenario.program == "order")
    if scenario.strategy.kind == "object" and (scenario.pile.count == 0 or scenario.support.bin):
        why = "in a bin the push has no choice of its line" if scenario.support.bin else "pile.count is 0"
        raise ConfigurationError(f"strategy.kind = 'object' cannot aim at an object, because {why}; make it 'pile'")
    return steps, hand, objects, layout, _controller_factory(scenario, hand)


def _steps(scenario: Scenario) -> int:
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
    """Return the plan with the longest push that the arm can follow to its end, and the start posture."""
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
        return line_plan(scenario.line, hand)
    return pile_strategy(
        scenario.strategy,
        hand,
        line.point,
        line.extent,
        farthest,
        grasp=scenario.program != "push",
        yaw=line.yaw,
        base_position=np.array(layout.base_position),
    )


def _controller_factory(scenario: Scenario, hand: Hand) -> Callable[[ArmModel, Array], Control]:
    """Read the gains now, so that a bad file is found before the pile is settled; bind arm and posture later."""
    kind = scenario.controller.kind or hand.controller
    gains = load_gains(scenario.controller.gains or path(scenario.robot, f"{kind}.toml"))
    wanted = MotionGains if kind == "operational_space" else Impedance
    if not isinstance(gains, wanted):
        raise ConfigurationError(
            f"{scenario.controller.gains}: holds {type(gains).__name__}, but controller.kind = {kind!r} takes "
            f"{wanted.__name__}; change controller.kind or the table's name"
        )
    solver, rate = scenario.controller.solver, scenario.controller.rate
    compiled = scenario.controller.compiled
    if compiled and kind != "operational_space":
        raise ConfigurationError(f"controller.compiled is for operational_space, and controller.kind is {kind!r}")
    free = _free_gains(scenario, hand, gains) if isinstance(gains, Impedance) else None
    lever = hand.transform_tool_to_flange.inverse().translation
    lag = 0.5 / (np.pi * scenario.sensor.cutoff) + 1.0 / rate

    def bind(arm: ArmModel, posture: Array) -> Control:
        if isinstance(gains, MotionGains):
            motion = OperationalSpaceController(arm, gains, posture, solver=solver, rate=rate, compiled=compiled)
            return lambda observation, setpoint, state: motion.step(observation, setpoint.reference, state=state)
        yielding = ContactImpedanceController.create(arm, gains, posture, solver, rate, free=free, wrench_lag=lag)

        def step(observation: Observation, setpoint: Setpoint, state: ArmState) -> ControllerOutput:
            if gains.inertia is not None:
                # The sensor reads at the flange.
                wrench = move_wrench(observation.wrench, state.rotation.dot(lever))
                observation = Observation(observation.time, observation.q, observation.v, wrench)
            return yielding.step(observation, setpoint.reference, state, setpoint.desired_force)

        return step

    return bind


def _free_gains(scenario: Scenario, hand: Hand, gains: Impedance) -> Impedance | None:
    """Return the arm's own gains where those of the scenario are for the time in which the hand presses."""
    if not gains.desired_force.any():
        return None
    if scenario.program == "line" or hand.parameters["use"]["normal_force"] == 0.0:
        raise ConfigurationError(
            f"{scenario.controller.gains}: desired_force has no effect, because hand = '{scenario.hand}' with "
            f"program = '{scenario.program}' never asks for a force; leave it out"
        )
    file = path(scenario.robot, "impedance.toml")
    own = load_gains(file)
    if not isinstance(own, Impedance):
        raise ConfigurationError(f"{file}: holds {type(own).__name__}, but an [impedance] is needed to move the arm")
    return own
