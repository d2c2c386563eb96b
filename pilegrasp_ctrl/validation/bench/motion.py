"""The input of every tick of the benchmark: the states of an arm that tracks a straight line."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...arm.model import ArmModel
from ...control.operational_space import OperationalSpaceController
from ...plant.arm_simulation import ArmSimulation
from ...robots import PANDA_FINGERS, panda_urdf
from ...trajectories.straight_line import StraightLine
from ...types import Array, Observation, Reference, frozen_array

RATE = 500.0
"""Rate of the control loop [Hz], as in the shipped scenarios."""

DISPLACEMENT = (0.0, 0.1, 0.05)
"""Displacement of the line [m]; chosen."""

SPEED = 0.1
"""Speed along the line [m/s]; chosen as the speed of a push."""

TIGHT = 0.6
"""Share of the line's largest joint speeds that the tightened arm may use [-]; chosen."""


class BenchArm(NamedTuple):
    """An arm of the benchmark.

    Attributes:
        name: Name of the arm, "wam7" or "panda".
        frame: Name of the controlled frame.
        posture: (nv,) Joint positions at the start of the line, and the preferred posture [rad].
    """

    name: str
    frame: str
    posture: Array

    def load(self) -> ArmModel:
        """Return the arm without a tool.

        Raises:
            ModelError: The Panda's files are not installed.
        """
        if self.name == "wam7":
            return ArmModel.load("wam7")
        return ArmModel.from_urdf(panda_urdf(), self.frame, locked_joints=PANDA_FINGERS, name="panda")


ARMS = (
    BenchArm("wam7", "flange", frozen_array([0.26, 0.82, -0.01, 1.68, -0.87, 0.81, -1.03], (7,), "posture")),
    BenchArm("panda", "panda_hand_tcp", frozen_array([0.1, -0.3, 0.2, -2.0, 0.1, 1.7, 0.3], (7,), "posture")),
)
"""Arms of the benchmark with their start postures [rad]; chosen. The WAM holds its hand over a pile in front of it, and
the Panda is near its manufacturer's ready pose. No axis of either arm is aligned with the world."""


class RecordedLine(NamedTuple):
    """States of an arm on its line, with their references.

    Attributes:
        arm: Arm.
        source: Arm of the benchmark from which it was loaded.
        observations: Observations, one for each control period.
        references: References, one for each control period.
    """

    arm: ArmModel
    source: BenchArm
    observations: tuple[Observation, ...]
    references: tuple[Reference, ...]


def record_line(source: BenchArm, arm: ArmModel) -> RecordedLine:
    """Run the closed loop along the line once, with joint friction, and keep the observation of every period."""
    line = StraightLine(arm.update(source.posture, np.zeros(arm.nv)).pose, DISPLACEMENT, SPEED)
    controller = OperationalSpaceController(arm, posture=source.posture, rate=RATE)
    observations: list[Observation] = []

    def torque(observation: Observation) -> Array:
        observations.append(observation)
        return controller.step(observation, line.at(observation.time)).command.torque

    for _ in ArmSimulation(arm).run(torque, source.posture, line.duration, rate=RATE):
        pass
    return RecordedLine(arm, source, tuple(observations), tuple(line.at(item.time) for item in observations))


def tighten(line: RecordedLine) -> ArmModel:
    """Return the line's arm with speed limits that the line would exceed, so that most ticks have active limits."""
    arm = line.arm
    peak = np.abs([observation.v for observation in line.observations]).max(axis=0)
    # A joint that hardly moves keeps a speed at which its limit can be held without chatter.
    speed = np.minimum(np.maximum(TIGHT * peak, 0.02), arm.velocity_limit)
    return arm.replace(velocity_limit=speed)
