"""The MuJoCo model of one attempt: table, support, arm, hand and objects, with explicit contact pairs."""

from __future__ import annotations

import colorsys
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import mujoco
import numpy as np

from ..config import Scenario
from ..planning.layout import TABLE_HALF_SIZE, WALL_DISTANCE, Layout
from ..robots import path
from .contact import SUPPORT, PairParameters, Rule, Surface, add_pair, combine, pair_parameters
from .hand import Hand
from .object_model import OBJECT_BIT
from .objects import Objects

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

SLOPE_FRICTION_RATIO = 10.0
"""The same ratio on a slope [-], chosen. There friction holds a heap, which flows if the friction yields; see also
`SLIP_STEPS`. At 30 the solver's iterations do not suffice, and the remaining error keeps apples and heavy spheres
awake."""

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
    """

    model: mujoco.MjModel
    arm_dofs: int
    objects: tuple[int, ...]
    hand_bodies: tuple[int, ...]
    object_qpos: int


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
        pos=[WALL_DISTANCE - TABLE_MARGIN, 0.0, 0.0],
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


def add_objects(spec: mujoco.MjSpec, objects: Objects, count: int, supports: list[str], rule: Rule) -> list[str]:
    """Add `count` objects, their nets, and all pairs with objects and supports; return the names of their geoms."""
    models = objects.assign_models(count)
    if any(each.shape == "ellipsoid" for each in models):
        spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_NATIVECCD
        spec.option.ccd_tolerance = COLLISION_TOLERANCE
    for index, each in enumerate(models):
        hue = (0.11 + 0.61803399 * index) % 1.0
        each.add_to(spec, index, (*colorsys.hsv_to_rgb(hue, 0.62, 0.92), 1.0))
    names = [f"object_{index}" for index in range(count)]
    for (first, one), (second, other) in combinations(zip(names, models, strict=True), 2):
        add_pair(spec, first, second, contact_parameters(spec, one.surface, other.surface, rule))
    for name, each in zip(names, models, strict=True):
        for support in supports:
            add_pair(spec, name, support, contact_parameters(spec, each.surface, SUPPORT, rule))
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
    spec: mujoco.MjSpec, hand: Hand, objects: Objects, count: int, layout: Layout, rule: Rule
) -> list[str]:
    """Add support, objects and all contact pairs to a spec with the hand; return the names of the objects."""
    supports = add_support(spec, layout)
    names = add_objects(spec, objects, count, supports, rule)
    models = objects.assign_models(count)
    on_support = contact_parameters(spec, hand.surface, SUPPORT, rule)
    for finger in hand.contact_geoms:
        for support in supports:
            add_pair(spec, finger, support, on_support, condim=3)
        for name, each in zip(names, models, strict=True):
            add_pair(spec, finger, name, contact_parameters(spec, hand.surface, each.surface, rule))
    return names


def build_scene(scenario: Scenario, hand: Hand, objects: Objects, layout: Layout) -> Scene:
    """Compile the scene of an attempt: first the arm, which carries the hand, then the objects."""
    spec = new_spec(scenario.sim.timestep, str(path(scenario.robot, f"{scenario.robot}.xml")))
    arm_joints = len(spec.joints)
    base = spec.body("base_link")
    pose = layout.transform_base_to_world
    base.pos = pose.translation
    mujoco.mju_mat2Quat(base.quat, pose.rotation.ravel())
    hand.add_to(spec, spec.site("flange"))
    # The arm's links have no explicit pairs; their contacts have MuJoCo's default parameters.
    for geom in spec.geoms:
        geom.contype |= OBJECT_BIT if geom.contype else 0
    # The collision plane has no edge, and these links are below its height beside the table.
    for link in ("base_link", "link1", "link2", "link3"):
        spec.add_exclude(bodyname1="world", bodyname2=link)
    names = add_surroundings(spec, hand, objects, scenario.pile.count, layout, scenario.sim.contact_rule)
    model = spec.compile()
    hand_bodies = tuple(i for i in range(model.nbody) if _is_below(model, i, model.body("sensor").id))
    return Scene(
        model=model,
        arm_dofs=arm_joints,
        objects=tuple(model.body(name).id for name in names),
        hand_bodies=hand_bodies,
        object_qpos=model.nq - 7 * len(names),
    )


def _is_below(model: Any, body: int, ancestor: int) -> bool:
    """Return whether a body is `ancestor` or one of its descendants."""
    while body not in (0, ancestor):
        body = model.body_parentid[body]
    return bool(body == ancestor)
