"""Obstacles around the two arms of the tests, their capsules, and runs toward targets among the obstacles.

Usage: PYTHONPATH=.:docs/studies python tests/helpers/collision_scenes.py TARGETS; it prints what happened at so many
targets of each arm and scene
"""

import sys
from functools import cache
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from arms import load
from example_arm import HOME
from pilegrasp_ctrl.arm.capsule import Capsule
from pilegrasp_ctrl.arm.capsules import capsules_of
from pilegrasp_ctrl.control.inverse_dynamics import InverseDynamics
from pilegrasp_ctrl.limits.collision_limit import CollisionLimit
from pilegrasp_ctrl.limits.obstacles import Box, Plane
from pilegrasp_ctrl.limits.standard import limits_of
from pilegrasp_ctrl.plant.arm_simulation import ArmSimulation
from pilegrasp_ctrl.robots import panda_urdf
from pilegrasp_ctrl.tasks.frame_task import FrameTask
from pilegrasp_ctrl.tasks.posture_task import PostureTask
from pilegrasp_ctrl.types import Pose

SCENES = ("box", "bin")
BIN = (0.56, 0.38, 0.16)  # inner length, width and height [m]
WALL = 0.02  # thickness of its walls [m]


@cache
def capsules(name: str) -> tuple[Capsule, ...]:
    """Return the capsules of an arm: stated for the WAM, fitted for the Panda, whose fingers become one."""
    if name == "wam7":
        return tuple(capsules_of("wam7"))
    fitted = [capsule for capsule in capsules_of(panda_urdf()) if "finger" not in capsule.frame]
    return (*fitted, Capsule("panda_hand", [0.0, 0.0, 0.04], [0.0, 0.0, 0.09], 0.035))


def obstacles(name: str, scene: str) -> tuple[list[Box | Plane], np.ndarray, np.ndarray]:
    """Return the obstacles of a scene, and lowest and highest target [m]."""
    x, y, z = load(name).update(HOME[name], np.zeros(7)).translation
    if scene == "box":
        middle = np.array([x + 0.2, y - 0.05, z - 0.05])
        box = Box([0.16, 0.3, 0.3], Pose(middle))
        return [box, Plane()], middle - np.array([0.1, 0.25, 0.2]), middle + np.array([0.2, 0.3, 0.25])
    floor, (length, width, height) = z - 0.25, BIN
    walls = {
        "far": (0.5 * (length + WALL), 0.0, WALL, width),
        "near": (-0.5 * (length + WALL), 0.0, WALL, width),
        "left": (0.0, 0.5 * (width + WALL), length + 2.0 * WALL, WALL),
        "right": (0.0, -0.5 * (width + WALL), length + 2.0 * WALL, WALL),
    }
    boxes = [
        Box([along, across, height], Pose([0.55 + dx, dy, floor + 0.5 * height]), f"bin_{side}")
        for side, (dx, dy, along, across) in walls.items()
    ]
    boxes.append(Box([length, width, WALL], Pose([0.55, 0.0, floor - 0.5 * WALL]), "bin_floor"))
    return boxes, np.array([0.25, -0.3, floor]), np.array([0.8, 0.3, floor + 0.45])


def targets(name: str, scene: str, seed: int):
    """Yield random poses among the obstacles, turned by about 0.2 rad from the home pose, without end."""
    _, low, high = obstacles(name, scene)
    home = load(name).update(HOME[name], np.zeros(7)).rotation
    rng = np.random.default_rng(seed)
    while True:
        yield Pose(rng.uniform(low, high), pin.exp3(0.2 * rng.normal(size=3)) @ home)


class Run(NamedTuple):
    """What happened on the way to a target: error at the end, depth in the margin, speed at the end, names."""

    error: float
    depth: float
    speed: float
    active: tuple[str, ...]
    fallbacks: int


def run_to(target: Pose, limit: CollisionLimit, name: str, duration: float, *, limited: bool) -> Run:
    """Move the tool from the home posture toward a target that jumps there, with or without the limit."""
    arm = load(name)
    task, q = FrameTask(arm), HOME[name]
    limits = [*limits_of(arm), limit] if limited else limits_of(arm)
    controller = InverseDynamics(arm, [task, PostureTask(arm, q)], limits)
    task.set_target(target)
    outputs, depth, every = [], 0.0, 1 if limited else 5

    def torque(observation):
        outputs.append(controller.step(observation))
        return outputs[-1].command.torque

    for count, sample in enumerate(ArmSimulation(arm, substeps=1).run(torque, q, duration)):
        if count % every:
            continue
        state = arm.update(sample.q, sample.v)
        depth = max(depth, limit.margin - min(limit.distances(state).values()))
    state = arm.update(sample.q, sample.v)
    error = float(np.linalg.norm(state.translation - target.translation))
    fallbacks = sum(bool(output.fallback) for output in outputs)
    return Run(error, depth, float(np.abs(state.v).max()), outputs[-1].active_limits, fallbacks)


class Tally(NamedTuple):
    """What happened at targets in reach.

    Attributes:
        reached: Targets whose way is free, and that were reached up to 0.1 mm, or 5 mm at a named pair.
        short: Those of them at which a named pair held the arm short.
        entered: Targets on whose way the arm enters the margin by over 10 mm without the limit.
        moving: Targets that cannot be reached, at which the arm still moves.
        lost: Other targets: not reached, and no pair is named.
        depth: Deepest that a capsule was in the margin with the limit [m].
        fallbacks: Periods without a torque of the program.
    """

    reached: int
    short: int
    entered: int
    moving: int
    lost: int
    depth: float
    fallbacks: int


def tally(name: str, scene: str, count: int, *, free_time: float = 2.0, time: float = 4.0) -> Tally:
    """Send an arm to random targets that it reaches without the limit, and count what happens with it.

    Args:
        name: Name of the arm.
        scene: Name of the scene.
        count: Number of targets that the arm reaches without the limit.
        free_time: Time in which it reaches a target without the limit [s].
        time: Time that it has with the limit [s].
    """
    limit = CollisionLimit(load(name), capsules(name), obstacles(name, scene)[0])
    reached = short = entered = moving = lost = fallbacks = tried = 0
    depth = 0.0
    for target in targets(name, scene, seed=1):
        free = run_to(target, limit, name, free_time, limited=False)
        if free.error > 1e-3:
            continue
        run = run_to(target, limit, name, time, limited=True)
        named = any(active.startswith("collision[") for active in run.active)
        if free.depth <= 0.0:
            within = run.error <= free.error + (5e-3 if named else 1e-4)
            reached, short = reached + within, short + (run.error > free.error + 1e-4)
        else:
            within = named or run.error < 1.5e-3
            moving, entered = moving + (run.speed > 1e-2), entered + (free.depth > 1e-2)
        lost, depth, fallbacks, tried = lost + (not within), max(depth, run.depth), fallbacks + run.fallbacks, tried + 1
        if tried == count:
            break
    return Tally(reached, short, entered, moving, lost, depth, fallbacks)


if __name__ == "__main__":
    for arm in ("panda", "wam7"):
        for place in SCENES:
            print(arm, place, tally(arm, place, int(sys.argv[1])))
