"""mink's inverse-kinematics tick, for comparison."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import mink
import mujoco

from ...robots import PANDA_FINGERS, panda_urdf, path
from .motion import RATE, RecordedLine


def mink_tick(line: RecordedLine) -> Callable[[int], object]:
    """Return `mink.solve_ik` as its documentation calls it: a frame task, a posture task, position and speed limits.

    A tick sets the configuration and the target and solves for joint velocities with DAQP. It has no dynamics, no
    torques and no accelerations, and its limits are those of one step.
    """
    model, frame_type = _model(line)
    configuration = mink.Configuration(model)
    frame = mink.FrameTask(line.source.frame, frame_type, position_cost=1.0, orientation_cost=1.0, lm_damping=1e-3)
    posture = mink.PostureTask(model, cost=1e-2)
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


def _model(line: RecordedLine) -> tuple[mujoco.MjModel, str]:
    """Return the bare arm for MuJoCo and the type of its controlled frame."""
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
