"""The control problem for the comparison with TSID's torques, in terms of the project alone."""

import json
from typing import NamedTuple

import numpy as np
import pinocchio as pin

import arms
from pilegrasp_ctrl.arm.model import ArmModel
from pilegrasp_ctrl.control.operational_space import OperationalSpaceController
from pilegrasp_ctrl.limits.motion_limits import VelocityLimit
from pilegrasp_ctrl.tasks.gains import MotionGains
from pilegrasp_ctrl.tasks.posture_task import PostureTask
from pilegrasp_ctrl.types import Observation, Pose, Reference
from places import DATA

FILE = DATA / "tsid_torques.json"

LIMITS = ("torque", "velocity")
"""Limits of the comparison: TSID and the project have the same speed limits, and different position limits."""

SPEED, HORIZON = 0.98, 0.004
"""Share of the joint speed limits that is allowed [-], and time in which it may be reached [s].

Both sides get these values, so that the recorded torques stay comparable if the project changes its margin or horizon.
"""

GAINS = MotionGains(stiffness=[900.0, 900.0, 900.0, 1600.0, 1600.0, 1600.0])

REGULARISATION = 1e-8
"""Number that TSID adds to the diagonal of every cost (DEFAULT_HESSIAN_REGULARIZATION in its solvers/fwd.hpp)."""


class Case(NamedTuple):
    """One state, one reference, and TSID's torques (nv,) [N·m]."""

    observation: Observation
    reference: Reference
    torque: np.ndarray


REGULAR = 0.11
"""Smallest singular value of J in any case; below 0.1 the project changes the requested motion, and TSID does not."""

FRAMES = {"wam7": "flange", "panda": "panda_hand_tcp"}


RATE = VelocityLimit(arms.load("panda"), 1.0).horizon / HORIZON
"""Control rate [Hz]."""


def load_arm(name: str) -> ArmModel:
    """The arm with its drives' reflected inertia, no friction, and a torque limit for each joint alone."""
    arm = arms.without_friction(name)
    kept = VelocityLimit(arm, RATE).speed / arm.velocity_limit
    speed = SPEED * arm.velocity_limit / kept
    return arm.replace(velocity_limit=speed, joint_to_motor=None, motor_torque_limit=None)


def posture_task(name: str) -> PostureTask:
    return PostureTask(arms.load(name), arms.HOME[name], stiffness=100.0, damping_ratio=1.0, weight=1e-4)


def our_controller(name: str, regularisation: float = REGULARISATION) -> OperationalSpaceController:
    """The project's controller with TSID's optimum.

    TSID adds eps |a|² to the cost. With a posture task of weight w that wants a*, the sum w |a - a*|² + eps |a|² is,
    up to a constant, (w + eps) |a - w / (w + eps) a*|²: a posture task again, its stiffness and damping scaled.
    """
    asked = posture_task(name)
    weight = asked.weight + regularisation
    share = asked.weight / weight
    ratio = 0.5 * asked.damping[0] / np.sqrt(asked.stiffness[0])
    posture = PostureTask(asked.arm, asked.target, share * asked.stiffness[0], ratio * np.sqrt(share), weight)
    return OperationalSpaceController(load_arm(name), GAINS, posture, friction=False, limits=LIMITS, rate=RATE)


def draw(arm: ArmModel, rng: np.random.Generator, demand: float) -> tuple[Observation, Reference]:
    """Return a state and a reference whose motion grows with `demand`: 0.1 is gentle, 10 saturates the arm."""
    while True:
        q = arm.q_lower + (arm.q_upper - arm.q_lower) * rng.uniform(0.1, 0.9, arm.nv)
        if np.linalg.svd(arm.update(q, np.zeros(arm.nv)).J, compute_uv=False)[-1] > REGULAR:
            break
    speed = SPEED * arms.load(arm.name).velocity_limit
    v = min(0.1 * demand, 0.97) * speed * rng.uniform(-1.0, 1.0, arm.nv)
    pose = arm.update(q, v).pose
    # The project's law corrects larger errors at a bounded speed, and TSID's does not. The rest of the demand is
    # therefore in the acceleration.
    rotation = pin.exp3(min(0.02 * demand, 0.07) * rng.uniform(-1.0, 1.0, 3)) @ pose.rotation
    target = Pose(pose.translation + min(0.005 * demand, 0.03) * rng.uniform(-1.0, 1.0, 3), rotation)
    twist, acceleration = 0.1 * rng.uniform(-1.0, 1.0, 6), 5.0 * demand * rng.uniform(-1.0, 1.0, 6)
    return Observation(0.0, q, v), Reference(target, twist, acceleration)


def recorded() -> dict[str, list[Case]]:
    """The cases of each arm that `record_tsid.py` wrote."""
    table = json.loads(FILE.read_text(encoding="utf-8"))
    return {name: [_case(row) for row in rows] for name, rows in table["cases"].items()}


def _case(row: dict[str, list[float]]) -> Case:
    pose = Pose(np.array(row["translation"]), np.reshape(row["rotation"], (3, 3)))
    reference = Reference(pose, np.array(row["twist"]), np.array(row["acceleration"]))
    return Case(Observation(0.0, np.array(row["q"]), np.array(row["v"])), reference, np.array(row["torque"]))
