"""Pink's inverse-kinematics tick, for comparison; needs the package pin-pink."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pinocchio as pin
from pink import Configuration, solve_ik  # type: ignore[import-not-found,import-untyped,unused-ignore]
from pink.tasks import FrameTask, PostureTask  # type: ignore[import-not-found,import-untyped,unused-ignore]

from .motion import RATE, RecordedLine


def pink_tick(line: RecordedLine) -> Callable[[int], object]:
    """Return `pink.solve_ik` as its documentation calls it: a frame task, a posture task, the model's own limits.

    A tick sets the configuration and the target and solves for joint velocities with DAQP. It has no dynamics, no
    torques and no accelerations, and its limits are those of one step.
    """
    model = line.arm.pinocchio_model
    model.lowerPositionLimit, model.upperPositionLimit = np.array(line.arm.q_lower), np.array(line.arm.q_upper)
    model.velocityLimit = np.array(line.arm.velocity_limit)
    configuration = Configuration(model, model.createData(), line.source.posture)
    frame = FrameTask(line.source.frame, position_cost=1.0, orientation_cost=1.0, lm_damping=1e-3)
    posture = PostureTask(cost=1e-2)
    posture.set_target(line.source.posture)
    tasks = [frame, posture]
    positions = [observation.q for observation in line.observations]
    targets = [pin.SE3(np.array(item.pose.rotation), np.array(item.pose.translation)) for item in line.references]
    count = len(positions)

    def tick(index: int) -> object:
        index %= count
        configuration.update(positions[index])
        frame.set_target(targets[index])
        return solve_ik(configuration, tasks, 1.0 / RATE, solver="daqp")

    return tick
