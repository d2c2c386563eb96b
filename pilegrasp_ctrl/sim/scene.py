"""The MuJoCo model of one attempt: table, support, arm, hand and objects, with explicit contact pairs."""

from __future__ import annotations

import colorsys
from dataclasses import dataclass
from itertools import combinations, product
from typing import Any

import mujoco
import numpy as np

from ..config import Scenario
from ..exceptions import ModelError
from ..planning.layout import TABLE_HALF_SIZE, Layout
from ..planning.simulated_arm import simulated_arm
from ..vectors import in_order
from .arm_body import file_of, mount_arm
from .arm_spread import ArmFactors, apply_factors, draw_factors
from .contact import SUPPORT, PairParameters, Rule, Surface, add_pair, combine, pair_parameters
from .hand import Hand
from .hand_drive import HandDrive
from .object_model import OBJECT_BIT
from .objects import Objects
from .pad import Pad, soften

WOOD = (0.72, 0.60, 0.46, 1.0)
"""Colour of the table (rgba)."""

WALL_COLOR = (0.62, 0.68, 0.74, 0.45)
"""Colour of the walls (rgba)."""

TABLE_MARGIN = 0.15
"""Distance of the drawn table's centre from the wall [m], chosen; the collision plane has no edge."""

SUPPORT_BIT = 1
"""Contact type of table and walls, chosen; the arm's collision shapes have it as affinity."""

SOLVER_ITERATIONS = 30
"""Largest number of CG iterations in a step [-], chosen; each step starts from the last solution."""

COLLISION_TOLERANCE = 1e-10
"""Tolerance of libccd [m], which finds the contacts of ellipsoids; chosen. At MuJoCo's 1e-6 it misses the shallowest.
MuJoCo's own search (4.0) stops at a wrong face about once in a thousand shallow contacts of two ellipsoids. It reports
14 mm for apples that overlap by 0.01 mm, which throws them apart. `Stepper` handles cylinders."""

FRICTION_RATIO = 3.0
"""Ratio of a contact's impedance in friction to that along its normal [-], MuJoCo's `impratio`; chosen."""

SLOPE_FRICTION_RATIO = 20.0
"""The same ratio on a slope [-], chosen. There friction holds a heap, which flows if the friction yields; see also
`SLIP_STEPS`. At 10 balls, whose contacts give way by `REST_SAG`, creep by 0.3 mm in 3 s. Far above, the solver's
iterations do not suffice, and the remaining error keeps a heap awake."""

SLEEP_TOLERANCE = 5e-3
"""Generalised velocity, scaled by length, below which an island falls asleep [m/s]; chosen."""

SLOPE_SLEEP_TOLERANCE = 5e-4
"""The same velocity on a slope [m/s], chosen. Bodies sleep after ten slow steps. At the larger tolerance a ball
that has bounced off the low wall would fall asleep at its turning point, and stay there."""


@dataclass(frozen=True)
class Scene:
    """Compiled scene and the addresses in it.

    Attributes:
        model: MuJoCo model.
        arm_dofs: Number of arm joints; they come first in qpos, qvel and ctrl.
        objects: Body ids of the objects.
        hand_bodies: Body ids of sensor and hand.
        object_qpos: First qpos address of the objects' free joints, which are consecutive.
        drive: Drive of the hand's actuators, whose controls follow those of the arm.
    """

    model: mujoco.MjModel
    arm_dofs: int
    objects: tuple[int, ...]
    hand_bodies: tuple[int, ...]
    object_qpos: int
    drive: HandDrive


def new_spec(timestep: float, file: str | None = None) -> mujoco.MjSpec:
    """Return a spec, empty or read from `file`, with the numerics that all models share."""
    spec = mujoco.MjSpec.from_file(file) if file else mujoco.MjSpec()
    spec.compiler.degree = False
    option = spec.option
    option.timestep = timestep
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    # Newton sometimes stalls on a light finger between two balls, and a stalled step throws both away.
    option.solver = mujoco.mjtSolver.mjSOL_CG
    option.iterations = SOLVER_ITERATIONS
    option.impratio = FRICTION_RATIO
    # A non-finite state must reach the watchdog; by default MuJoCo would start again from time zero.
    option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    # A sleeping pile costs nothing while the arm is in the air; a touch wakes it.
    option.enableflags |= mujoco.mjtEnableBit.mjENBL_SLEEP
    option.sleep_tolerance = SLEEP_TOLERANCE
    return spec


def add_support(spec: mujoco.MjSpec, layout: Layout) -> list[str]:
    """Add table and walls, set the gravity of their tilt, and return the names of their geoms."""
    spec.option.gravity = layout.gravity
    if layout.tilt != 0.0:
        spec.option.sleep_tolerance = SLOPE_SLEEP_TOLERANCE
        spec.option.impratio = SLOPE_FRICTION_RATIO
    spec.worldbody.add_geom(
        name="table",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        pos=[layout.room.wall_distance - TABLE_MARGIN, 0.0, 0.0],
        size=[*TABLE_HALF_SIZE, 0.05],
        rgba=WOOD,
        contype=SUPPORT_BIT,
        conaffinity=0,
    )
    for wall in layout.walls:
        spec.worldbody.add_geom(
            name=wall.name,
            type=mujoco.mjtGeom.mjGEOM_BOX,
            pos=wall.center,
            quat=[np.cos(wall.yaw / 2.0), 0.0, 0.0, np.sin(wall.yaw / 2.0)],
            size=wall.half_size,
            rgba=WALL_COLOR,
            contype=SUPPORT_BIT,
            conaffinity=0,
        )
    return ["table", *(wall.name for wall in layout.walls)]


def add_objects(
    spec: mujoco.MjSpec, objects: Objects, count: int, supports: list[str], rule: Rule, mutual: bool = True
) -> list[str]:
    """Add `count` objects, their nets, and all pairs with supports; return the names of their geoms.

    Pairs among the objects are added if they are `mutual`.
    """
    models = objects.assign_models(count)
    if any(each.shape == "ellipsoid" for each in models):
        spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_NATIVECCD
        spec.option.ccd_tolerance = COLLISION_TOLERANCE
    for index, each in enumerate(models):
        hue = (0.11 + 0.61803399 * index) % 1.0
        each.add_to(spec, index, (*colorsys.hsv_to_rgb(hue, 0.62, 0.92), 1.0))
    names = [f"object_{index}" for index in range(count)]
    for (first, one), (second, other) in combinations(zip(names, models, strict=True), 2) if mutual else ():
        parameters = contact_parameters(spec, one.surface, other.surface, rule)
        for pair in product(one.geom_names(first), other.geom_names(second)):
            add_pair(spec, *pair, parameters)
    for name, each in zip(names, models, strict=True):
        for geom, support in product(each.geom_names(name), supports):
            add_pair(spec, geom, support, contact_parameters(spec, each.surface, SUPPORT, rule))
    if objects.net is not None:
        for first_member in range(0, count, objects.net.members):
            members = names[first_member : first_member + objects.net.members]
            objects.net.add_to(spec, f"net_{first_member // objects.net.members}", members)
    return names


def contact_parameters(spec: mujoco.MjSpec, first: Surface, second: Surface, rule: Rule) -> PairParameters:
    """Return the parameters of the contact of two surfaces at the step and under the gravity of `spec`."""
    slope = bool(np.any(spec.option.gravity[:2]))
    return pair_parameters(combine(first, second, rule), spec.option.timestep, slope)


def add_surroundings(
    spec: mujoco.MjSpec, hand: Hand, objects: Objects, count: int, layout: Layout, rule: Rule, mutual: bool = True
) -> list[str]:
    """Add support, objects and all contact pairs to a spec with the hand; return the names of the objects."""
    supports = add_support(spec, layout)
    names = add_objects(spec, objects, count, supports, rule, mutual)
    models = objects.assign_models(count)
    for finger in hand.contact_geoms:
        on_support = hand_contact(spec, hand, finger, SUPPORT, 0.0, rule)
        for support in supports:
            add_pair(spec, finger, support, on_support, condim=3)
        for name, each in zip(names, models, strict=True):
            parameters = hand_contact(spec, hand, finger, each.surface, 1.0 / each.mass, rule)
            for geom in each.geom_names(name):
                add_pair(spec, finger, geom, parameters)
    add_hand_pairs(spec, hand, rule)
    return names


def add_hand_pairs(spec: mujoco.MjSpec, hand: Hand, rule: Rule) -> None:
    """Add the contacts of the hand's own parts with one another. Two pads give way by the sum of both."""
    hard = contact_parameters(spec, hand.surface, hand.surface, rule)
    for one, other in hand.touching_pairs:
        pads = [hand.pads[name] for name in (one, other) if name in hand.pads]
        give = in_order(pad.give for pad in pads)
        pad = Pad(give, hand.inverse_mass(one))
        add_pair(spec, one, other, soften(hard, pad, hand.inverse_mass(other)) if pads else hard, condim=3)


def hand_contact(
    spec: mujoco.MjSpec, hand: Hand, geom: str, other: Surface, inverse_mass: float, rule: Rule
) -> PairParameters:
    """Return the parameters of the contact of a hand's geom with a body of another surface and inverse mass [1/kg]."""
    hard = contact_parameters(spec, hand.surface, other, rule)
    pad = hand.pads.get(geom)
    return hard if pad is None else soften(hard, pad, inverse_mass)


def build_scene(scenario: Scenario, hand: Hand, objects: Objects, layout: Layout, seed: int | None = None) -> Scene:
    """Compile the scene of an attempt: first the arm, which carries the hand, then the objects.

    With a seed the simulated arm differs from its model within its spread; see `draw_factors`.

    Raises:
        ModelError: The arm is not known, or cannot be simulated.
    """
    described = simulated_arm(scenario.robot)
    spec = new_spec(scenario.sim.timestep, file_of(described))
    arm = mount_arm(spec, described)
    pose = layout.transform_base_to_world
    arm.base.pos = pose.translation
    mujoco.mju_mat2Quat(arm.base.quat, pose.rotation.ravel())
    hand.add_to(spec, arm.flange)
    # The arm's links have no explicit pairs; their contacts have MuJoCo's default parameters.
    for geom in spec.geoms:
        geom.contype |= OBJECT_BIT if geom.contype else 0
    # The collision plane has no edge, and these links are below its height beside the table.
    for link in arm.beside_table:
        spec.add_exclude(bodyname1="world", bodyname2=link)
    pile, rule = scenario.pile, scenario.sim.contact_rule
    names = add_surroundings(spec, hand, objects, pile.count, layout, rule, pile.mutual_contacts)
    model = compile_scene(spec, scenario.robot)
    hand_bodies = tuple(i for i in range(model.nbody) if _is_below(model, i, model.body("sensor").id))
    base = model.body(arm.base.name).id
    links = [i for i in range(1, model.nbody) if _is_below(model, i, base) and i not in hand_bodies]
    center = ArmFactors(np.full(arm.joints, scenario.sim.joint_friction), scenario.sim.arm_mass)
    apply_factors(model, links, draw_factors(described.spread, center, seed))
    return Scene(
        model=model,
        arm_dofs=arm.joints,
        objects=tuple(model.body(name).id for name in names),
        hand_bodies=hand_bodies,
        object_qpos=model.nq - 7 * len(names),
        drive=hand.drive,
    )


def compile_scene(spec: mujoco.MjSpec, robot: str) -> mujoco.MjModel:
    """Compile a spec with an arm.

    Raises:
        ModelError: MuJoCo refuses the arm, for example because no solid body has the inertia of one of its links.
    """
    try:
        return spec.compile()
    except (ValueError, RuntimeError) as error:
        raise ModelError(f"{robot}: MuJoCo cannot simulate it: {' '.join(str(error).split())}") from None


def _is_below(model: Any, body: int, ancestor: int) -> bool:
    """Return whether a body is `ancestor` or one of its descendants."""
    while body not in (0, ancestor):
        body = model.body_parentid[body]
    return bool(body == ancestor)
