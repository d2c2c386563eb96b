"""The same pile in MuJoCo and in PyBullet: settled, pushed and timed; for compare_pybullet.py alone."""

from __future__ import annotations

import time
from dataclasses import dataclass

import mujoco
import numpy as np

from bullet_world import BulletWorld
from pilegrasp_ctrl.planning.layout import Layout, make_layout
from pilegrasp_ctrl.sections import PileConfig, SupportConfig
from pilegrasp_ctrl.sim.contact import Rule
from pilegrasp_ctrl.sim.drop import FRAME_HEIGHT, drop_poses, pile_model
from pilegrasp_ctrl.sim.objects import OBJECT_MODELS
from pilegrasp_ctrl.sim.pile import LIFT_SPEED, settle_pile
from pilegrasp_ctrl.statistics import markdown_row
from pilegrasp_ctrl.validation.physics.plate_push import SPEED, push, push_model, start_of_plate

STEP = 1e-3
BALL = OBJECT_MODELS["light_sphere"]
SETTLE_TIME = 2.0
DISTANCE = 0.12
F_GRASP = 17.0


@dataclass(frozen=True)
class PileFacts:
    """Mean and largest height of the centres, median distance from the middle, travel to 17 N [m]; mean force [N]."""

    height: float
    top: float
    spread: float
    travel: float
    force: float


def facts(poses: np.ndarray, travel: np.ndarray, force: np.ndarray) -> PileFacts:
    """Sum up a settled pile (n, 7) and its push; the force is the mean over the push, smoothed over 20 ms for 17 N."""
    offset = poses[:, :2] - np.median(poses[:, :2], axis=0)
    smooth = np.convolve(force, np.full(20, 0.05), "same")
    reached = np.flatnonzero(smooth > F_GRASP)
    first = float(travel[reached[0]]) if reached.size else np.nan
    spread = float(np.median(np.linalg.norm(offset, axis=1)))
    return PileFacts(float(poses[:, 2].mean()), float(poses[:, 2].max()), spread, first, float(force.mean()))


def row(name: str, piles: list[PileFacts]) -> str:
    """Return one line of the table: means over the seeds, the travel over those that reached 17 N."""
    height, top, spread = (1e3 * np.mean([getattr(p, key) for p in piles]) for key in ("height", "top", "spread"))
    travels = [1e3 * pile.travel for pile in piles if np.isfinite(pile.travel)]
    reached = f"{np.mean(travels):.0f} mm ({len(travels)} of {len(piles)})" if travels else f"0 of {len(piles)}"
    force = np.mean([pile.force for pile in piles])
    return markdown_row((name, f"{height:.1f}", f"{top:.1f}", f"{spread:.0f}", reached, f"{force:.2f}"))


def in_mujoco(count: int, seed: int, rule: Rule) -> PileFacts:
    """Settle and push with the library's own functions."""
    layout = _layout(count)
    poses = settle_pile(BALL, count, layout, seed, rule, STEP).poses
    result = push(push_model(BALL, count, layout, rule, STEP), poses, BALL.bounding_radius, DISTANCE)
    return facts(poses, result.travel, result.force)


def in_bullet(count: int, seed: int) -> PileFacts:
    """Drop from the same poses into the same frame, lift it likewise, and push likewise."""
    layout = _layout(count)
    poses = settle_in_bullet(count, seed)
    world = BulletWorld(push_model(BALL, count, layout, "product", STEP), BALL)
    world.place(poses, start_of_plate(poses, BALL.bounding_radius))
    travel: list[float] = []
    force: list[float] = []
    while not travel or travel[-1] < DISTANCE:
        world.step()
        own = world.force()
        if own > 0.0 or travel:
            travel.append((travel[-1] if travel else 0.0) + SPEED * STEP)
            force.append(own)
    world.close()
    return facts(poses, np.array(travel), np.array(force))


def settle_in_bullet(count: int, seed: int) -> np.ndarray:
    """Return the settled poses (count, 7)."""
    layout = _layout(count)
    world = BulletWorld(pile_model(BALL, count, layout, "product", STEP), BALL)
    world.place(drop_poses(BALL, count, layout, np.random.default_rng(seed)))
    for step in range(round((2.0 * SETTLE_TIME + FRAME_HEIGHT / LIFT_SPEED) / STEP)):
        world.lift(min(max(step * STEP - SETTLE_TIME, 0.0) * LIFT_SPEED, FRAME_HEIGHT))
        world.step()
    poses = world.poses()
    world.close()
    return poses


def step_costs(count: int, steps: int = 600) -> tuple[float, float]:
    """Return the median seconds of a step in MuJoCo and in Bullet while the same pile is pushed, in turns."""
    layout = _layout(count)
    poses = settle_pile(BALL, count, layout, 0, "product", STEP).poses
    model = push_model(BALL, count, layout, "product", STEP)
    data, world = mujoco.MjData(model), BulletWorld(model, BALL)
    data.qpos[0] = start_of_plate(poses, BALL.bounding_radius)
    data.qpos[1:] = poses.ravel()
    world.place(poses, float(data.qpos[0]))
    own, other = [], []
    for _ in range(steps):
        data.qvel[0] = SPEED
        start = time.perf_counter()
        mujoco.mj_step(model, data)
        own.append(time.perf_counter() - start)
        other.append(world.step())
    world.close()
    return float(np.median(own)), float(np.median(other))


def _layout(count: int) -> Layout:
    return make_layout(SupportConfig(), PileConfig(count=count), BALL.diameter)
