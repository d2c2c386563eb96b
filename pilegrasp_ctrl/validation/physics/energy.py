"""Energy: a falling object keeps its energy, and no contact returns more than it took."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import mujoco
import numpy as np

from ...planning.layout import Layout, make_layout
from ...sections import PileConfig, SupportConfig
from ...sim.drop import drop_poses, pile_model
from ...sim.hand import Hand
from ...sim.object_model import ObjectModel
from ...sim.objects import OBJECT_MODELS
from ...sim.pile import settle_pile
from ...sim.stepper import Stepper
from .contact_rig import GRAVITY, SHIPPED_STEP, ContactRig
from .physics_check import PhysicsCheck
from .plate_push import push, push_model

FALL = 0.5
"""Height of a free fall [m]; chosen."""

BLOCK = 0.05
"""Length of the blocks whose largest energies are compared [s]; contacts store energy for 10 ms and return it."""

BOUNCE_TIME, SETTLE_TIME = 4.0, 2.0
"""Time after which a bouncing object, and a dropped pile, are at rest [s]; chosen."""

PUSH_DISTANCE = 0.12
"""Travel of the plate [m]; chosen."""

GAIN_TOLERANCE = 0.1
"""Allowed gain of energy [%]; chosen. The energies themselves are rounded at 1e-13."""

DRIFT_TOLERANCE = 1.0
"""Allowed loss of energy in the fall [%]; chosen."""

PILES = (("light_sphere", 18), ("cube", 14), ("cylinder", 14))
"""Object and count of each pile."""


def fall_drift(rig: ContactRig) -> float:
    """Return the energy that a spinning object loses in a free fall of `FALL`, as a share of m g h."""
    spot = rig.spots["table"]
    data = rig.place(spot, FALL + 0.05)
    data.qvel[3:6] = 10.0, -20.0, 5.0
    rig.model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    mujoco.mj_forward(rig.model, data)
    start, top = data.energy.sum(), data.qpos[2]
    while data.qpos[2] > top - FALL:
        mujoco.mj_step(rig.model, data)
    mujoco.mj_forward(rig.model, data)
    return float((start - data.energy.sum()) / (rig.object_model.mass * GRAVITY * FALL))


def gain(energies: Sequence[float], timestep: float) -> float:
    """Return the largest excess of a block's energy over the least energy of an earlier block [J]."""
    size = round(BLOCK / timestep)
    count = len(energies) // size
    largest = np.asarray(energies)[: count * size].reshape(count, size).max(axis=1)
    return float((largest[1:] - np.minimum.accumulate(largest)[:-1]).max())


def bounce_gain(rig: ContactRig, where: str) -> float:
    """Let the object bounce until it rests; return the energy it gains on the way, as a share of its fall's."""
    data = rig.place(rig.spots[where], FALL)
    rig.model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    energies = _record(rig.model, data, BOUNCE_TIME)
    return gain(energies, rig.model.opt.timestep) / (rig.object_model.mass * GRAVITY * FALL)


def settling_gain(
    object_model: ObjectModel, count: int, layout: Layout, seed: int, timestep: float = SHIPPED_STEP
) -> float:
    """Return the energy that a pile gains while it settles in its frame, as a share of its energy loss."""
    model = pile_model(object_model, count, layout, "paper", timestep)
    model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    data = mujoco.MjData(model)
    data.qpos[:] = drop_poses(object_model, count, layout, np.random.default_rng(seed)).ravel()
    energies = _record(model, data, SETTLE_TIME)
    return gain(energies, timestep) / (energies[0] - energies[-1])


def pushing_gain(
    object_model: ObjectModel, count: int, layout: Layout, seed: int, timestep: float = SHIPPED_STEP
) -> float:
    """Return the energy that a pushed pile gains beyond the work done on it, as a share of that work."""
    poses = settle_pile(object_model, count, layout, seed, "paper", timestep).poses
    result = push(
        push_model(object_model, count, layout, "paper", timestep), poses, object_model.bounding_radius, PUSH_DISTANCE
    )
    work = float((result.force * np.diff(result.travel, prepend=0.0)).sum())
    return gain(list(result.surplus), timestep) / work


def energy_checks() -> Iterator[PhysicsCheck]:
    """Check a free fall, single bounces, and piles that settle and are pushed."""
    shovel, ball = Hand.load("shovel"), OBJECT_MODELS["light_sphere"]
    drift = 100.0 * fall_drift(ContactRig.build(ball, shovel))
    yield PhysicsCheck("energy: lost in a free fall of 0.5 m", 0.0, drift, DRIFT_TOLERANCE, "%")
    for name, hand, where in (
        ("light_sphere", "shovel", "table"),
        ("light_sphere", "shovel", "shovel floor"),
        ("light_sphere", "rbo_hand2", "palm"),
        ("cube", "shovel", "table"),
        ("cylinder", "shovel", "table"),
        ("lime", "shovel", "table"),
    ):
        share = 100.0 * bounce_gain(ContactRig.build(OBJECT_MODELS[name], Hand.load(hand)), where)
        words = name.replace("_", " ")
        yield PhysicsCheck(f"energy: gained by {words} on {where}", 0.0, share, GAIN_TOLERANCE, "%", "<=")
    for name, count in PILES:
        object_model = OBJECT_MODELS[name]
        layout = make_layout(SupportConfig(), PileConfig(object=name, count=count), object_model.diameter)
        words = f"{count} {name.replace('_', ' ')}s"
        settled = 100.0 * settling_gain(object_model, count, layout, 0)
        yield PhysicsCheck(f"energy: gained by {words} that settle", 0.0, settled, GAIN_TOLERANCE, "%", "<=")
        pushed = 100.0 * pushing_gain(object_model, count, layout, 0)
        yield PhysicsCheck(f"energy: gained by {words} that are pushed", 0.0, pushed, GAIN_TOLERANCE, "%", "<=")


def _record(model: mujoco.MjModel, data: mujoco.MjData, duration: float) -> list[float]:
    energies = []
    stepper = Stepper(model, data)
    for _ in range(round(duration / model.opt.timestep)):
        stepper.step()
        energies.append(float(data.energy.sum()))
    return energies
