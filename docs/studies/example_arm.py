"""The two arms that tracking is measured on: the WAM that ships, and the Panda of example-robot-data."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from pilegrasp_ctrl.arm.model import ArmModel
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.plant.sensor_noise import SensorNoise
from pilegrasp_ctrl.robots import PANDA_FINGERS, description, panda_urdf
from pilegrasp_ctrl.types import Array

HOME = {
    "panda": np.array([0.1, -0.3, 0.2, -2.0, 0.1, 1.7, 0.3]),
    "wam7": np.array([0.26, 0.82, -0.01, 1.68, -0.87, 0.81, -1.03]),
}
"""Where each arm starts [rad]: away from limits and singular postures; chosen, the WAM's near a pile's pre-grasp."""


class ExampleArm(NamedTuple):
    """An arm, where it starts, and how well it is measured.

    Attributes:
        arm: its model, friction included where it is known: the WAM's is, the Panda's URDF has none.
        home: (nv,) start posture [rad].
        noise: of the encoders. For the Panda no figure is published; it is given the WAM's, joint by joint (chosen).
    """

    arm: ArmModel
    home: Array
    noise: SensorNoise


@cache
def example_arm(name: str) -> ExampleArm:
    """Return one of the arms.

    Args:
        name: "wam7" or "panda".

    Raises:
        ConfigurationError: where there is no such arm.
        ModelError: where its files are missing.
    """
    if name not in HOME:
        raise ConfigurationError(f"no arm {name!r} to measure; the arms are {', '.join(sorted(HOME))}")
    noise = SensorNoise.of_encoders(description("wam7")["transmission"]["joint_to_motor"])
    if name == "wam7":
        return ExampleArm(ArmModel.load("wam7"), HOME[name], noise)
    panda = ArmModel.from_urdf(panda_urdf(), "panda_hand_tcp", locked_joints=PANDA_FINGERS, name="panda")
    return ExampleArm(panda, HOME[name], noise)
