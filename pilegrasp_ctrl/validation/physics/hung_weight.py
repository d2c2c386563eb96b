"""The wrist sensor reads a known weight that hangs from the hand."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from ...sections import SensorConfig
from ...sim.hand import Hand
from ...sim.scene import new_spec
from ...sim.wrist_sensor import WristSensor
from ...types import Array
from .contact_rig import GRAVITY, SHIPPED_STEP
from .physics_check import PhysicsCheck

MASS = 1.0
"""Mass of the weight [kg]; chosen."""

TILTS = 10
"""Number of random orientations of the hand [-]; chosen."""

SETTLE_TIME = 2.0
"""Time after which the fingers are at rest [s]; chosen."""

TOLERANCE = 0.01
"""Allowed error of the force as a share of the weight [-]; chosen."""

SILENT = SensorConfig(force_noise=0.0, torque_noise=0.0, cutoff=1000.0, bias=0.0, drift=0.0)
"""Sensor without noise, bias and drift."""


def reading(hand_name: str, tilt: Array) -> Array:
    """Return the force (3,) [N], world axes, that is read with 1 kg hung from a hand turned by `tilt` (3,) [rad]."""
    hand = Hand.load(hand_name)
    spec = new_spec(SHIPPED_STEP)
    quaternion = np.zeros(4)
    angle = float(np.linalg.norm(tilt))
    mujoco.mju_axisAngle2Quat(quaternion, tilt / angle, angle)
    hand.add_to(spec, spec.worldbody.add_site(name="flange", pos=[0.0, 0.0, 1.0], quat=quaternion))
    spec.body("sensor").add_geom(size=[0.001, 0.0, 0.0], pos=[0.0, 0.0, 0.12], mass=MASS, contype=0, conaffinity=0)
    model = spec.compile()
    data = mujoco.MjData(model)
    for _ in range(round(SETTLE_TIME / SHIPPED_STEP)):
        mujoco.mj_step(model, data)
    return WristSensor(model, hand.mass_properties(), SILENT, SHIPPED_STEP, seed=0).read(data)[:3]


def hung_weight_checks() -> Iterator[PhysicsCheck]:
    """Check both hands: the largest error of the reading over ten tilts, against (0, 0, -9.81) N."""
    tilts = np.random.default_rng(0).uniform(-np.pi, np.pi, (TILTS, 3))
    weight = np.array([0.0, 0.0, -MASS * GRAVITY])
    for hand in ("rbo_hand2", "shovel"):
        worst = max(float(np.linalg.norm(reading(hand, tilt) - weight)) for tilt in tilts)
        words = f"wrench: 1 kg hung from {hand.replace('_', ' ')}, largest error"
        yield PhysicsCheck(words, 0.0, worst, TOLERANCE * MASS * GRAVITY, "N", "<=")
