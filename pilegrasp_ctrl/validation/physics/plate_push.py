"""A plate pushes a settled pile at constant speed: its force, its work, and the energy of the pile."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from ...planning.layout import Layout
from ...sim.contact import END_EFFECTOR_RANK, Rule, Surface, add_pair, combine, pair_parameters
from ...sim.object_model import ObjectModel
from ...sim.scene import add_objects, add_support, new_spec
from ...sim.stepper import Stepper
from ...types import Array

PLATE = Surface(lateral=0.5, spinning=0.001, rolling=0.001, restitution=0.8, rank=END_EFFECTOR_RANK)
"""Surface of the paper's end-effector (V-A)."""

HALF_SIZE = (0.01, 0.06, 0.05)
"""Half size of the plate [m]: as wide as the shovel, and taller than a ball."""

CLEARANCE = 0.001
"""Gap between plate and table [m]; chosen."""

MASS = 100.0
"""Mass of the plate [kg]; chosen so that 100 N change its speed by 1 mm/s in a step, which is then corrected."""

SPEED = 0.1
"""Speed of the plate [m/s]; that of a push in the shipped scenarios."""

APPROACH = 0.05
"""Longest travel of the plate before it touches an object [m]; chosen."""


@dataclass(frozen=True, slots=True, eq=False)
class PlatePush:
    """A push, sampled each step.

    Attributes:
        travel: (n,) Travel of the plate since it first touched an object [m].
        force: (n,) Force of the plate on the pile along the push [N].
        surplus: (n,) Energy of the objects less the work that the plate has done [J].
        positions: (objects, 3) Positions of the objects at the end [m].
    """

    travel: Array
    force: Array
    surplus: Array
    positions: Array


def push_model(object_model: ObjectModel, count: int, layout: Layout, rule: Rule, timestep: float) -> mujoco.MjModel:
    """Return a model of the plate, whose slide along x is the first joint, the supports and the objects."""
    spec = new_spec(timestep)
    plate = spec.worldbody.add_body(name="plate", pos=[0.0, layout.frame_center[1], CLEARANCE + HALF_SIZE[2]])
    plate.add_joint(name="plate", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[1.0, 0.0, 0.0])
    box = mujoco.mjtGeom.mjGEOM_BOX
    plate.add_geom(name="plate", type=box, size=HALF_SIZE, mass=MASS, contype=0, conaffinity=0)
    names = add_objects(spec, object_model, count, add_support(spec, layout), rule)
    parameters = pair_parameters(combine(PLATE, object_model.surface, rule), timestep)
    for name in names:
        add_pair(spec, "plate", name, parameters)
    spec.option.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    return spec.compile()


def start_of_plate(poses: Array, radius: float) -> float:
    """Return the x coordinate [m] of the plate's middle at which it nearly touches the pile (n, 7)."""
    in_the_way = np.abs(poses[:, 1] - np.median(poses[:, 1])) < HALF_SIZE[1] + radius
    return float(poses[in_the_way, 0].min()) - radius - HALF_SIZE[0] - 0.002


def push(model: mujoco.MjModel, poses: Array, radius: float, distance: float, limit: float = np.inf) -> PlatePush:
    """Push the settled objects (n, 7) over a distance [m], or until the plate feels more than `limit` [N]."""
    data = mujoco.MjData(model)
    data.qpos[0] = start_of_plate(poses, radius)
    data.qpos[1:] = poses.ravel()
    stepper = Stepper(model, data)
    step, work = model.opt.timestep, 0.0
    travel: list[float] = []
    force: list[float] = []
    surplus: list[float] = []
    farthest = data.qpos[0] + distance + APPROACH
    while (not travel or travel[-1] < distance) and data.qpos[0] < farthest:
        data.qvel[0] = SPEED
        stepper.step()
        # The engine reports the energy of the state from which the step began.
        energy = data.energy.sum()
        own = -data.qfrc_constraint[0]
        if own > 0.0 or travel:
            travel.append((travel[-1] if travel else 0.0) + SPEED * step)
            force.append(own)
            surplus.append(energy - work)
        work += own * SPEED * step
        if own > limit:
            break
    return PlatePush(np.array(travel), np.array(force), np.array(surplus), data.qpos[1:].reshape(-1, 7)[:, :3].copy())
