"""The arm for a simulator, as plain numbers: bodies, joints, motors, friction and shapes. Whatever the file was.

An arm's folder may hold an MJCF for the simulation beside its URDF, as the WAM's does; it is used unchanged. The bodies
of every other arm are built from the model that the controllers use. Torque limits, friction and inertia of the
simulated arm are therefore those of the folder.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from ..robots import folder_digest
from ..types import Array, Pose

DEFAULT_BASE_RADIUS = 0.2
"""Radius around the first joint's axis within which links may be beside the table, below its top [m]; chosen, that of
the WAM's base."""

SMALLEST_MASS = 1e-6
"""Mass of a body without one in the simulation [kg], which needs one; chosen, far below what moves a joint."""

SMALLEST_INERTIA = 1e-9
"""Moment of inertia of such a body [kg·m²]; chosen."""


class LinkShape(NamedTuple):
    """A capsule around a link: the ends (3,) of its segment, which are equal for a ball, and its radius [m]."""

    start: Array
    end: Array
    radius: float


@dataclass(frozen=True, slots=True, eq=False)
class ArmJoint:
    """The joint of a body.

    Attributes:
        axis: (3,) Unit vector of the axis, in the body's frame.
        slides: Whether the joint is prismatic.
        lower: Lower position limit [rad, m]; -inf for none.
        upper: Upper position limit [rad, m]; inf for none.
        torque_limit: Largest torque of the motor [N·m, N].
        armature: Reflected inertia of the drive [kg·m², kg].
        coulomb: Coulomb friction [N·m, N].
        viscous: Viscous friction [N·m·s/rad, N·s/m].
    """

    axis: Array
    slides: bool
    lower: float
    upper: float
    torque_limit: float
    armature: float
    coulomb: float
    viscous: float


@dataclass(frozen=True, slots=True, eq=False)
class ArmBody:
    """A body, whose frame is that of its joint.

    Attributes:
        name: Name of the first link in it.
        parent: Index of the body that carries it; -1 for the base.
        pose: Pose in the parent's frame, at the joint's zero.
        joint: Joint that moves it; None for the base.
        mass: Mass [kg].
        center_of_mass: (3,) Centre of mass [m].
        inertia: (3, 3) Inertia about the centre of mass [kg·m²].
        shapes: Capsules, in the body's frame.
    """

    name: str
    parent: int
    pose: Pose
    joint: ArmJoint | None
    mass: float
    center_of_mass: Array
    inertia: Array
    shapes: tuple[LinkShape, ...]


@dataclass(frozen=True, slots=True, eq=False)
class ArmBodies:
    """The bodies of an arm, from the base on.

    Attributes:
        bodies: Bodies, each after the one that carries it, the base first.
        flange_body: Index of the body that carries the flange.
        flange: Pose of the flange in that body's frame.
        together: Pairs of indices of bodies that do not touch one another.
    """

    bodies: tuple[ArmBody, ...]
    flange_body: int
    flange: Pose
    together: tuple[tuple[int, int], ...]


class ArmSpread(NamedTuple):
    """How far a real arm may be from its model: largest deviation of friction and mass, as shares."""

    friction: float = 0.0
    mass: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class SimulatedArm:
    """An arm for the simulator.

    Attributes:
        name: Name as in the scenario key `robot`.
        joint_names: Names of the joints.
        source: The bodies, or an MJCF to use as it is.
        base: Name of the base's body.
        flange: Name of the flange's site in such a file.
        beside_table: Names of the bodies that may be beside the table, below its top.
        postures: Postures (nv,) from which the search for a start posture begins [rad].
        spread: How far the arm may be from this description.
    """

    name: str
    joint_names: tuple[str, ...]
    source: ArmBodies | Path
    base: str
    flange: str
    beside_table: tuple[str, ...]
    postures: tuple[Array, ...]
    spread: ArmSpread


def simulated_arm(robot: str) -> SimulatedArm:
    """Return an arm for the simulator.

    Args:
        robot: Name of an arm that ships, or path of a folder.

    Raises:
        ModelError: There is no such arm, or its files do not describe one that can be simulated.
    """
    # Pinocchio is loaded when an arm is built, and not by whoever simulates without one.
    from .arm_bodies import build_arm

    return build_arm(robot, folder_digest(robot))
