"""The two arms that everything in control is tested on, and a simulation of them without contacts."""

import importlib.metadata
from collections.abc import Callable

import numpy as np
import pinocchio as pin

from pilegrasp_ctrl.arm_model import ArmModel
from pilegrasp_ctrl.types import Observation

HOME = {
    "panda": np.array([0.1, -0.3, 0.2, -2.0, 0.1, 1.7, 0.3]),
    "wam7": np.array([0.26, 0.82, -0.01, 1.68, -0.87, 0.81, -1.03]),
}
ARMS = tuple(HOME)


def panda_urdf():
    """example-robot-data 6 is data without a Python module."""
    package = importlib.metadata.distribution("example-robot-data")
    (file,) = [file for file in package.files if str(file).endswith("urdf/panda.urdf")]
    return package.locate_file(file)


def load(name: str, **arguments) -> ArmModel:
    if name == "wam7":
        return ArmModel.load(
            "wam7", **{"tool_frame" if k == "transform_tool_to_frame" else k: v for k, v in arguments.items()}
        )
    fingers = ["panda_finger_joint1", "panda_finger_joint2"]
    return ArmModel.from_urdf(panda_urdf(), "panda_hand_tcp", locked_joints=fingers, **arguments)


def without_friction(name: str, tool=None, **changes) -> ArmModel:
    """The same arm with no friction in its model, and other limits or frictions where given."""
    arm = load(name, tool=tool)
    limits = {key: getattr(arm, key) for key in ("q_lower", "q_upper", "velocity_limit", "torque_limit")}
    frame = "flange" if name == "wam7" else "panda_hand_tcp"
    return ArmModel(arm.pinocchio_model, frame, name=name, **{**limits, **changes})


def random_states(arm: ArmModel, count: int, seed: int = 0, speed: float = 0.5):
    """Pairs q, v between the position limits, at up to `speed` of the largest velocity."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        q = arm.q_lower + (arm.q_upper - arm.q_lower) * rng.uniform(0.05, 0.95, arm.nv)
        yield q, speed * arm.velocity_limit * rng.uniform(-1.0, 1.0, arm.nv)


def simulate(
    arm: ArmModel,
    step: Callable[[Observation], np.ndarray],
    q: np.ndarray,
    duration: float,
    *,
    rate: float = 500.0,
    substeps: int = 2,
    external: Callable[[np.ndarray, np.ndarray], np.ndarray] | None = None,
    coulomb: np.ndarray | None = None,
):
    """Integrate the arm from rest by the midpoint rule under torques held for a period; yield time, q, v and torque.

    `external(q, v)` is a joint torque from outside. With `coulomb`, friction that stops a joint within a step where it
    can and otherwise opposes its motion.
    """
    model = arm.pinocchio_model
    data = model.createData()
    q, v, step_time = q.copy(), np.zeros(arm.nv), 1.0 / (rate * substeps)
    for tick in range(round(duration * rate)):
        torque = step(Observation(tick / rate, q, v))
        yield tick / rate, q, v, torque
        for _ in range(substeps):
            total = torque if external is None else torque + external(q, v)
            if coulomb is not None:
                total = total + _friction(
                    pin.crba(model, data, q), pin.aba(model, data, q, v, total), v, coulomb, step_time
                )
            a = pin.aba(model, data, q, v, total)
            middle = pin.aba(model, data, q + 0.5 * step_time * v, v + 0.5 * step_time * a, total)
            q = q + step_time * (v + 0.5 * step_time * a)
            v = v + step_time * middle


def _friction(M, a, v, coulomb, step_time):
    """Projected Gauss-Seidel on the impulses that would bring every joint to rest, each within its Coulomb friction."""
    inverse = np.linalg.inv(M)
    friction = np.zeros(len(v))
    for _ in range(10):
        for joint in range(len(v)):
            rate = v[joint] / step_time + a[joint] + inverse[joint] @ friction
            wanted = friction[joint] - rate / inverse[joint, joint]
            friction[joint] = np.clip(wanted, -coulomb[joint], coulomb[joint])
    return friction
