"""Penetration: nothing passes through anything at 0.7 m/s, and a resting pile neither overlaps nor creeps."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from ...config import load_scenario
from ...episode import run_attempt
from ...exceptions import SimulationError
from ...planning.arm_room import default_room
from ...planning.layout import make_layout
from ...programs.attempt import prepare
from ...sections import PileConfig, SupportConfig
from ...sim.drop import FRAME_HEIGHT, pile_model
from ...sim.hand import Hand
from ...sim.monitors import MAX_DROP_PENETRATION, MAX_PENETRATION
from ...sim.objects import OBJECT_MODELS
from ...sim.pile import settle_pile
from ...sim.stepper import Stepper
from .contact_rig import SHIPPED_STEP, ContactRig
from .physics_check import PhysicsCheck

MAX_SPEED = 0.7
"""Fastest push that a scenario allows [m/s]."""

REST_TIME = 1.0
"""Time for which a pile at rest is watched [s]; chosen."""

MAX_OVERLAP, MAX_CREEP = 1.0, 1.0
"""Overlap [mm] and speed [mm/s] allowed in a pile at rest; chosen."""

PILES = (
    ("light_sphere", 18),
    ("heavy_sphere", 18),
    ("cylinder", 14),
    ("cube", 14),
    ("apple", 18),
    ("lime_net", 15),
)
"""Object and count of each pile at rest."""


def impact_depth(rig: ContactRig, where: str, speed: float) -> float:
    """Throw the object at a spot at `speed` [m/s]; return its depth [m], or infinity if it does not come back."""
    spot = rig.spots[where]
    data = rig.place(spot, 0.01)
    data.qvel[:3] = -speed * spot.normal
    surface = data.qpos[:3].dot(spot.normal) - 0.01
    depth = 0.0
    for _ in range(round(0.2 / rig.model.opt.timestep)):
        mujoco.mj_step(rig.model, data)
        depth = max(depth, surface - data.qpos[:3].dot(spot.normal))
    return depth if data.qpos[:3].dot(spot.normal) > surface - MAX_DROP_PENETRATION else float("inf")


def passed_through(hand: str, count: int) -> int:
    """Push `count` balls, or the bare wall, at 0.7 m/s in an attempt; return the number of failures.

    A failure is an object behind the wall or below the table at the end, or a stop by the watchdog. The watchdog looks
    for contacts deeper than `MAX_PENETRATION` every 10 ms.
    """
    keys = {"hand": hand, "strategy.speed": MAX_SPEED, "pile.count": count}
    attempt = prepare(load_scenario("spheres_wall" if count else "push_wall", keys), 0)
    stopped = False
    try:
        run_attempt(attempt)
    except SimulationError:
        stopped = True
    scene, data = attempt.simulation.scene, attempt.simulation.data
    positions = data.xpos[list(scene.objects)]
    return int(stopped) + int(((positions[:, 0] > default_room().wall_distance) | (positions[:, 2] < 0.0)).sum())


def rest(name: str, count: int, seed: int = 0) -> tuple[float, float]:
    """Return the largest overlap [m] and the creep [m/s] of a settled pile within `REST_TIME`, as in an attempt."""
    object_model = OBJECT_MODELS[name]
    layout = make_layout(SupportConfig(), PileConfig(object=name, count=count), object_model.diameter)
    poses = settle_pile(object_model, count, layout, seed, "paper", SHIPPED_STEP).poses
    model = pile_model(object_model, count, layout, "paper", SHIPPED_STEP)
    data = mujoco.MjData(model)
    data.qpos[:] = poses.ravel()
    data.mocap_pos[0, 2] = 2.0 * FRAME_HEIGHT
    depth = 0.0
    stepper = Stepper(model, data)
    for _ in range(round(REST_TIME / SHIPPED_STEP)):
        stepper.step()
        depth = max(depth, -float(data.contact.dist.min(initial=0.0)))
    moved = np.linalg.norm(data.qpos.reshape(count, 7)[:, :3] - poses[:, :3], axis=1).max()
    return depth, float(moved) / REST_TIME


def penetration_checks() -> Iterator[PhysicsCheck]:
    """Check impacts and attempts at 0.7 m/s, then piles at rest."""
    limits = {"wall": MAX_PENETRATION["object", "support"], "shovel back": MAX_PENETRATION["hand", "object"]}
    for name in ("light_sphere", "heavy_sphere", "cube"):
        rig = ContactRig.build(OBJECT_MODELS[name], Hand.load("shovel"))
        for where, limit in limits.items():
            depth = 1e3 * impact_depth(rig, where, MAX_SPEED)
            words = f"depth: {name.replace('_', ' ')} into {where} at 0.7 m/s"
            yield PhysicsCheck(words, 0.0, depth, 1e3 * limit, "mm", "<=")
    for hand in ("rbo_hand2", "shovel"):
        for count, before in ((0, "the bare wall"), (1, "a ball before the wall")):
            words = f"passed through: {hand.replace('_', ' ')} against {before} at 0.7 m/s"
            yield PhysicsCheck(words, 0.0, passed_through(hand, count), 0.0, "-", "<=")
    for name, count in PILES:
        depth, creep = rest(name, count)
        words = f"{count} {name.replace('_', ' ')}s"
        yield PhysicsCheck(f"rest: overlap in {words}", 0.0, 1e3 * depth, MAX_OVERLAP, "mm", "<=")
        yield PhysicsCheck(f"rest: creep in {words}", 0.0, 1e3 * creep, MAX_CREEP, "mm/s", "<=")
