"""The inverse-kinematics ticks of mink and Pink, for comparison.

Both are called as their documentation does, with a frame task, a posture task, position and speed limits and DAQP. A
tick sets the configuration and the target and solves for joint velocities. It has no dynamics, no torques and no
accelerations, and its limits are those of one step.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

from ...robots import PANDA_FINGERS, panda_urdf, path
from .motion import RATE, RecordedLine

FRAME_COSTS: dict[str, Any] = {"position_cost": 1.0, "orientation_cost": 1.0, "lm_damping": 1e-3}
"""Costs and damping of the frame task in both libraries; chosen."""

POSTURE_COST = 1e-2
"""Cost of the posture task in both libraries [-]; chosen, small against the frame's."""


def mink_tick(line: RecordedLine) -> Callable[[int], object]:
    """Return the tick of `mink.solve_ik`."""
    import mink

    model, frame_type = _mujoco_model(line)
    configuration = mink.Configuration(model)
    frame = mink.FrameTask(line.source.frame, frame_type, **FRAME_COSTS)
    posture = mink.PostureTask(model, cost=POSTURE_COST)
    posture.set_target(line.source.posture)
    tasks = [frame, posture]
    speeds = dict(zip(line.arm.joint_names, line.arm.velocity_limit.tolist(), strict=True))
    limits = [mink.ConfigurationLimit(model), mink.VelocityLimit(model, speeds)]
    positions = [observation.q for observation in line.observations]
    targets = [
        mink.SE3.from_rotation_and_translation(mink.SO3.from_matrix(item.pose.rotation), item.pose.translation)
        for item in line.references
    ]
    count = len(positions)

    def tick(index: int) -> object:
        index %= count
        configuration.update(positions[index])
        frame.set_target(targets[index])
        return mink.solve_ik(configuration, tasks, 1.0 / RATE, "daqp", limits=limits)

    return tick


def pink_tick(line: RecordedLine) -> Callable[[int], object]:
    """Return the tick of `pink.solve_ik` with the model's own limits; it needs the package pin-pink."""
    from pink import Configuration, solve_ik  # type: ignore[import-not-found,import-untyped,unused-ignore]
    from pink.tasks import FrameTask, PostureTask  # type: ignore[import-not-found,import-untyped,unused-ignore]

    model = line.arm.pinocchio_model
    model.lowerPositionLimit, model.upperPositionLimit = np.array(line.arm.q_lower), np.array(line.arm.q_upper)
    model.velocityLimit = np.array(line.arm.velocity_limit)
    configuration = Configuration(model, model.createData(), line.source.posture)
    frame = FrameTask(line.source.frame, **FRAME_COSTS)
    posture = PostureTask(cost=POSTURE_COST)
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


def _mujoco_model(line: RecordedLine) -> tuple[Any, str]:
    """Return the bare arm for MuJoCo and the type of its controlled frame."""
    import mujoco

    if line.source.name == "wam7":
        return mujoco.MjModel.from_xml_path(str(path("wam7", "wam7.xml"))), "site"
    return mujoco.MjModel.from_xml_string(_without_meshes(panda_urdf())), "body"


def _without_meshes(urdf: Path) -> str:
    """Return a URDF that MuJoCo compiles without mesh files, its fixed frames kept and the fingers' joints locked."""
    robot = ElementTree.parse(urdf).getroot()
    for link in robot.findall("link"):
        for shape in (*link.findall("visual"), *link.findall("collision")):
            link.remove(shape)
    for joint in robot.findall("joint"):
        if joint.get("name") in PANDA_FINGERS:
            joint.set("type", "fixed")
    options = ElementTree.SubElement(robot, "mujoco")
    ElementTree.SubElement(options, "compiler", fusestatic="false", balanceinertia="true")
    return ElementTree.tostring(robot, encoding="unicode")
