"""The two arms of the tests of control, their states, and a simulation of them without contacts."""

from collections.abc import Callable

import numpy as np
import pinocchio as pin

from example_arm import HOME
from pilegrasp_ctrl.arm.model import ArmModel
from pilegrasp_ctrl.arm.state import ArmState
from pilegrasp_ctrl.plant.arm_simulation import ArmSimulation
from pilegrasp_ctrl.robots import PANDA_FINGERS, panda_urdf
from pilegrasp_ctrl.types import MassProperties, Observation, Pose, Reference

ARMS = tuple(HOME)


def load(name: str, **arguments) -> ArmModel:
    if name == "wam7":
        return ArmModel.load(
            "wam7", **{"tool_frame" if k == "transform_tool_to_frame" else k: v for k, v in arguments.items()}
        )
    return ArmModel.from_urdf(panda_urdf(), "panda_hand_tcp", locked_joints=PANDA_FINGERS, **arguments)


def without_friction(name: str, tool=None, **changes) -> ArmModel:
    """Return the arm without friction in its model, and with the given changes of limits or friction."""
    none = {"friction_coulomb": None, "friction_viscous": None}
    own_motors = {"joint_to_motor": None, "motor_torque_limit": None} if "torque_limit" in changes else {}
    return load(name, tool=tool).replace(name=name, **{**none, **own_motors, **changes})


def random_states(arm: ArmModel, count: int, seed: int = 0, speed: float = 0.5):
    """Yield pairs q, v between the position limits, at up to `speed` times the velocity limits."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        q = arm.q_lower + (arm.q_upper - arm.q_lower) * rng.uniform(0.05, 0.95, arm.nv)
        yield q, speed * arm.velocity_limit * rng.uniform(-1.0, 1.0, arm.nv)


def nearby(state: ArmState, turn: float = 0.05) -> Reference:
    """Return a moving reference 2.7 cm and 4 deg from the tool."""
    shift, rotation = np.array([0.01, -0.02, 0.015]), pin.exp3(np.array([turn, 0.0, -turn]))
    pose = Pose(state.translation + shift, rotation @ state.rotation)
    return Reference(pose, np.linspace(-0.1, 0.1, 6), np.linspace(0.5, -0.5, 6))


def quiet_states(arm: ArmModel, count: int):
    """Yield pairs q, v around the home posture, at which no limit is near."""
    rng = np.random.default_rng(1)
    for _ in range(count):
        yield HOME[arm.name] + rng.uniform(-0.1, 0.1, arm.nv), rng.uniform(-0.1, 0.1, arm.nv)


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
    """Run the library's plant from rest; yield time, q, v and torque.

    `external(q, v)` is a joint torque from outside. The plant's friction is `coulomb` alone, not the model's.
    """
    plant = PushedArm(arm, external, substeps=substeps, friction_coulomb=0.0 if coulomb is None else coulomb)
    for sample in plant.run(step, q, duration, rate=rate):
        yield sample.time, sample.q, sample.v, sample.torque


class PushedArm(ArmSimulation):
    """A plant with an external torque at its joints instead of a wrench at its tool."""

    def __init__(self, arm, push, **arguments):
        super().__init__(arm, friction_viscous=0.0, **arguments)
        self._push = push

    def external(self, q, v):
        return None if self._push is None else self._push(q, v)


HAND = MassProperties(0.6, [0.03, 0.0, 0.08], np.diag([1.5e-3, 1.5e-3, 6e-4]))
# Joint friction of the Panda, Coulomb [N·m] and viscous [N·m·s/rad]; its URDF has none; chosen.
PANDA_FRICTION = np.array([1.0, 1.0, 1.0, 1.0, 0.5, 0.5, 0.5])


def with_friction(name, tool=None):
    """Return an arm whose model has joint friction."""
    if name == "wam7":
        wam = load(name)
        return without_friction(
            name, tool=tool, friction_coulomb=wam.friction_coulomb, friction_viscous=wam.friction_viscous
        )
    return without_friction(name, tool=tool, friction_coulomb=PANDA_FRICTION, friction_viscous=PANDA_FRICTION)
