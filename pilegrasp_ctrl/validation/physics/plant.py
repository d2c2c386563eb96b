"""The simulated arm differs from its model as much as was asked for."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from ...arm.model import ArmModel
from ...config import load_scenario
from ...planning.simulated_arm import simulated_arm
from ...programs.attempt import prepare
from ...sim.arm_spread import ArmFactors, draw_factors
from .physics_check import PhysicsCheck

ROBOT = "wam7"
"""Arm that is checked."""

SEEDS = 1000
"""Number of seeds whose draws are looked at [-]; chosen."""


def added_gravity(factor: float, seed: int = 0) -> float:
    """Return the gravity torques that links heavier by `factor` add over those of Pinocchio's arm without a hand [-].

    It is the slope of the one against the other over the joints, in the start posture of a push.
    """
    arm = ArmModel.load(ROBOT)
    torques = []
    for mass in (1.0, factor):
        simulation = prepare(load_scenario("push_wall", {"sim.arm_mass": mass}), seed).simulation
        data = simulation.data
        data.qvel[:] = 0.0
        mujoco.mj_forward(simulation.scene.model, data)
        torques.append(data.qfrc_bias[: arm.nv].copy())
    gravity = arm.update(data.qpos[: arm.nv], np.zeros(arm.nv)).h
    return float((torques[1] - torques[0]) @ gravity / (gravity @ gravity))


def plant_checks() -> Iterator[PhysicsCheck]:
    """Check the weight of heavier links, and the ends of the factors that are drawn."""
    arm = simulated_arm(ROBOT)
    spread = arm.spread
    yield PhysicsCheck("plant: gravity that links 3 % heavier add", 3.0, 100.0 * added_gravity(1.03), 0.1, "%")
    nominal = ArmFactors(np.ones(len(arm.joint_names)), 1.0)
    drawn = [draw_factors(spread, nominal, seed) for seed in range(SEEDS)]
    friction, mass = np.array([each.friction for each in drawn]), np.array([each.mass for each in drawn])
    drawings = (("friction of joints", friction, spread.friction), ("mass of links", mass, spread.mass))
    for name, values, share in drawings:
        for end, found, sign in (("least", values.min(), -1.0), ("most", values.max(), 1.0)):
            requested = 1.0 + sign * share
            yield PhysicsCheck(f"plant: {name}, {end} of {SEEDS} draws", requested, float(found), 0.02 * share, "-")
