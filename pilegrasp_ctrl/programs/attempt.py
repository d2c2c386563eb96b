"""Preparation of an attempt: settle the pile, plan the motion, and check its poses before anything moves."""

from __future__ import annotations

import logging
import math
from dataclasses import dataclass
from typing import NamedTuple

from ..arm.model import ArmModel
from ..config import Scenario
from ..exceptions import ConfigurationError
from ..planning.layout import Layout, make_layout
from ..planning.strategy import Plan
from ..sim.contact import CONTACT_STEPS, largest_timestep
from ..sim.hand import Hand
from ..sim.objects import Objects, objects_of, own_frame, spread
from ..sim.pile import Pile, settle_pile, without_mutual_contacts
from ..sim.scene import build_scene
from ..sim.simulation import Simulation
from ..sim.start_posture import StartPosture
from ..sim.touch_sensor import TouchSensor
from ..sim.wrist_sensor import WristSensor
from ..types import Array, Pose
from .bin_reach import bin_goals
from .controller import Control, ControllerFactory, controller_factory
from .derived_room import room_of
from .notes import notes_on
from .program import Course, Program
from .registry import program_of
from .workplace import Station, Workplace, believed_poses, push_line

_LOGGER = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Attempt:
    """An attempt that is ready to run.

    Attributes:
        scenario: Scenario of the attempt.
        seed: Seed of pile and sensor noise.
        arm: Arm with the known mass of the hand, tool frame and base.
        transform_known_to_scene: Transform from the frame of arm and plan to the frame of the simulation. It is the
            identity unless the true slope of the floor differs from the known one.
        course: Program, planned for the pile.
        simulation: Simulation at the start posture, with the settled pile.
        control: Function from observation and setpoint to torque.
        period: Control period [s].
        pile: Pile as it settled.
        notes: Sentences on what the result rests on, such as parts that are too heavy for the hand.
        grasp_force: F_grasp by the mass of the objects [N]; None if it is that of the scenario.
    """

    scenario: Scenario
    seed: int
    arm: ArmModel
    transform_known_to_scene: Pose
    course: Course
    simulation: Simulation
    control: Control
    period: float
    pile: Pile
    notes: tuple[str, ...] = ()
    grasp_force: float | None = None

    @property
    def plan(self) -> Plan:
        """Start pose and primitives."""
        return self.course.plan

    @property
    def posture(self) -> Array:
        """(nv,) joint angles at the start [rad]."""
        return self.course.posture


class _Parts(NamedTuple):
    """Parts of an attempt that do not depend on the settled pile.

    Attributes:
        steps: Physics steps in a control period.
        hand: Hand.
        objects: Model of the objects.
        layout: Layout with the known slope of the floor.
        program: What the attempt does.
        make_controller: Function that makes the controller.
    """

    steps: int
    hand: Hand
    objects: Objects
    layout: Layout
    program: Program
    make_controller: ControllerFactory


def prepare(scenario: Scenario, seed: int) -> Attempt:
    """Settle the pile, plan, check that every pose is within reach, and build the scene.

    Raises:
        PilegraspError: A name, file or key of the scenario is invalid, the pile does not settle, or a pose is out of
            reach.
    """
    steps, hand, objects, layout, program, make_controller = _parts(scenario)
    planned = with_force_by_mass(scenario, objects)
    slope_error = math.radians(scenario.support.slope_error_deg)
    objects = spread(objects, scenario.pile, seed)
    numerics = scenario.sim.contact_rule, scenario.sim.timestep
    pile = settle_pile(objects, scenario.pile.count, layout.with_rising_floor(slope_error), seed, *numerics)
    if not scenario.pile.mutual_contacts:
        pile = without_mutual_contacts(pile, objects, layout.with_rising_floor(slope_error), *numerics)
    _LOGGER.info("%s, seed %d: %d objects are at rest", scenario.name, seed, len(pile.poses))
    true_layout = layout
    # What follows plans with what the arm believes.
    layout, poses = layout.as_believed(scenario.known), believed_poses(scenario.known, pile.poses)
    if scenario.traits.touches and not layout.goals:
        line = push_line(scenario, hand, objects, layout, poses, None)
        layout = layout.with_base_behind_push(line.touch(scenario.strategy), line.point, pile.poses[:, :2])
    # The plan is made for the known floor and runs on the true floor.
    true_layout = true_layout.with_base_of(layout).with_rising_floor(slope_error)
    true_layout = true_layout.with_lower_floor(scenario.known.table_z)
    known_to_scene = true_layout.transform_from(layout)
    period = steps * scenario.sim.timestep
    makers = {hand.name: make_controller}

    def make_station(place: Workplace, posture: Array, object_poses: Array) -> Station:
        tool, theirs = place.hand.mass_properties(), place.hand.transform_tool_to_flange
        base = layout.transform_base_to_world
        arm = ArmModel.load(scenario.robot, tool=tool, tool_frame=theirs, base=base, gravity=layout.gravity)
        # Gains and tracking are judged on the arm as it is modelled, so a line in free space keeps it.
        drawn = seed if scenario.traits.touches else None
        scene = build_scene(scenario, place.hand, objects, true_layout, drawn)
        sensor = WristSensor(scene.model, tool, scenario.sensor, period, seed, known_to_scene.rotation.T)
        label = f"{scenario.config_hash()}-{seed}"
        feels = scenario.traits.touches and scenario.strategy.close_on != "force"
        simulation = Simulation(scene, sensor, steps, true_layout.walls, label, TouchSensor(scene) if feels else None)
        simulation.reset(posture, object_poses)
        make = makers.get(place.hand.name) or controller_factory(scenario, place.hand, layout.walls)
        return Station(arm, simulation, make(arm, posture))

    search = StartPosture(scenario.robot, hand.transform_tool_to_flange, layout.transform_base_to_world)
    workplace = Workplace(planned, hand, objects, layout, poses, search, make_station, seed)
    course = program.begin(workplace)
    station = make_station(workplace, course.posture, pile.poses)
    return Attempt(
        scenario=scenario,
        seed=seed,
        arm=station.arm,
        transform_known_to_scene=known_to_scene,
        course=course,
        simulation=station.simulation,
        control=station.control,
        period=period,
        pile=pile,
        notes=notes_on(hand, objects, scenario.pile.count),
        grasp_force=None if planned is scenario else planned.strategy.grasp_force,
    )


def with_force_by_mass(scenario: Scenario, objects: Objects) -> Scenario:
    """Return the scenario with F_grasp from `strategy.force_per_mass` and the mean mass of its objects, if given."""
    share = scenario.strategy.force_per_mass
    if share is None or not scenario.pile.count:
        return scenario
    models = objects.assign_models(scenario.pile.count)
    force = share * math.fsum(model.mass for model in models) / len(models)
    strategy = scenario.strategy.model_copy(update={"grasp_force": force})
    return scenario.model_copy(update={"strategy": strategy})


def check(scenario: Scenario) -> None:
    """Check a scenario without its pile: names, files, gains, and combinations of keys.

    Raises:
        ConfigurationError: A name, file or gain is invalid, or two keys exclude one another.
    """
    _parts(scenario)


def _parts(scenario: Scenario) -> _Parts:
    """Return the checked parts of an attempt that do not depend on the settled pile."""
    steps = _steps(scenario)
    _check_delay(scenario)
    hand = _first_hand(scenario)
    objects = objects_of(scenario.pile)
    _check_contact_steps(scenario, hand, objects)
    order = scenario.order if scenario.traits.delivers else None
    room, frame = room_of(scenario.robot, hand), own_frame(scenario.pile, objects)
    layout = make_layout(scenario.support, scenario.pile, objects.diameter, order, room, frame)
    if scenario.strategy.kind == "object" and (scenario.pile.count == 0 or scenario.support.bin):
        why = "the goal in a bin fixes the push line" if scenario.support.bin else "pile.count is 0"
        raise ConfigurationError(f"strategy.kind = 'object' cannot aim at an object, because {why}; make it 'pile'")
    if layout.bin is not None and scenario.traits.touches:
        layout = layout.with_goals(bin_goals(scenario, hand, layout))
        if not layout.goals[0].name.startswith(scenario.support.kind):
            raise ConfigurationError(
                "support.kind = 'corner' is not possible: in this bin no push of hand and arm runs into a corner; make "
                "it 'wall', or the bin larger by support.bin_size"
            )
    return _Parts(
        steps, hand, objects, layout, program_of(scenario.program), controller_factory(scenario, hand, layout.walls)
    )


def _first_hand(scenario: Scenario) -> Hand:
    """Return the hand that begins: the scenario's, or the one that pushes in its place."""
    pushing = scenario.strategy.pushing_hand
    return Hand.load(scenario.hand, scenario.hand_model) if pushing is None else Hand.load(pushing)


def _check_contact_steps(scenario: Scenario, hand: Hand, objects: Objects) -> None:
    """Refuse a physics step that leaves fewer than `CONTACT_STEPS` in a bounce whose duration is stated."""
    touching = {hand.name: hand.surface}
    if scenario.strategy.pushing_hand is not None:
        touching[scenario.hand] = Hand.load(scenario.hand, scenario.hand_model).surface
    touching |= {each.name: each.surface for each in objects.assign_models(scenario.pile.count)}
    for name, surface in touching.items():
        # The quotient of two numbers such as 0.005 and 0.001 is not exact.
        if scenario.sim.timestep > (1.0 + 1e-9) * largest_timestep(surface):
            raise ConfigurationError(
                f"sim.timestep = {scenario.sim.timestep:g} s is too long: a bounce of {name} lasts "
                f"{surface.contact_time:g} s and needs {CONTACT_STEPS} steps; make it "
                f"{largest_timestep(surface):g} or less"
            )


def _check_delay(scenario: Scenario) -> None:
    """Refuse a delay of the sensor that is less than half a control period, because readings come once a period."""
    delay, period = scenario.sensor.delay, 1.0 / scenario.controller.rate
    if 0.0 < delay < 0.5 * period:
        raise ConfigurationError(
            f"sensor.delay = {delay:g} s has no effect, because the sensor is read every {period:g} s; "
            f"give whole control periods, such as {period:g}"
        )


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
