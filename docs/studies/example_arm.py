"""The two arms of the tracking tables, and the conditions that change plant, sensors or controller."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

from pilegrasp_ctrl.arm.model import ArmModel
from pilegrasp_ctrl.control.operational_space import OperationalSpaceController
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.plant.arm_simulation import ArmSimulation
from pilegrasp_ctrl.plant.sensor_noise import SensorNoise
from pilegrasp_ctrl.robots import description
from pilegrasp_ctrl.types import Array
from pilegrasp_ctrl.validation.bench.motion import ARMS

HOME = {arm.name: arm.posture for arm in ARMS}
"""Start posture (nv,) of each arm [rad], as in the benchmark: away from limits and singular postures."""


class ExampleArm(NamedTuple):
    """An arm, its start posture, and the noise of its encoders.

    Attributes:
        arm: Model with joint friction if it is known: the WAM has it, the Panda's URDF has none.
        home: (nv,) Start posture [rad].
        noise: Noise of the encoders; the Panda has the WAM's, joint by joint (chosen), because none is published.
    """

    arm: ArmModel
    home: Array
    noise: SensorNoise


@cache
def example_arm(name: str) -> ExampleArm:
    """Return one of the arms.

    Args:
        name: Name of the arm, "wam7" or "panda".

    Raises:
        ConfigurationError: No arm has this name.
        ModelError: The arm's files are missing.
    """
    found = next((arm for arm in ARMS if arm.name == name), None)
    if found is None:
        raise ConfigurationError(f"no arm {name!r} to measure; the arms are {', '.join(HOME)}")
    noise = SensorNoise.of_encoders(description("wam7")["transmission"]["joint_to_motor"])
    return ExampleArm(found.load(), found.posture, noise)


@dataclass(frozen=True, slots=True)
class Condition:
    """One difference between the plant and the controller's model.

    Attributes:
        name: Name in the table.
        mass_factor: Mass of the plant's links over the model's [-].
        payload: Mass at the tool frame's origin that is not in the model [kg].
        noisy: Whether the controller sees the encoders' noise.
        friction: Whether the plant has the model's joint friction; the controller then compensates it.
        compensated: Whether the controller feeds friction forward.
    """

    name: str
    mass_factor: float = 1.0
    payload: float = 0.0
    noisy: bool = False
    friction: bool = True
    compensated: bool = True

    def applies_to(self, arm: ArmModel) -> bool:
        """Return whether the condition differs from "nominal" for an arm; conditions of friction need friction."""
        has_friction = bool(arm.friction_coulomb.any() or arm.friction_viscous.any())
        return has_friction or (self.friction and self.compensated)

    def plant(self, example: ExampleArm) -> ArmSimulation:
        """Return the plant."""
        friction = None if self.friction else 0.0
        return ArmSimulation(
            example.arm,
            mass_factor=self.mass_factor,
            payload=self.payload,
            noise=example.noise if self.noisy else None,
            friction_coulomb=friction,
            friction_viscous=friction,
        )

    def controller(self, example: ExampleArm, rate: float) -> OperationalSpaceController:
        """Return the operational-space controller with its default gains."""
        compensate = self.friction and self.compensated
        return OperationalSpaceController(example.arm, posture=example.home, friction=compensate, rate=rate)


CONDITIONS = (
    Condition("nominal"),
    Condition("mass +10 %", mass_factor=1.1),
    Condition("mass -10 %", mass_factor=0.9),
    Condition("payload 0.5 kg", payload=0.5),
    Condition("sensor noise", noisy=True),
    Condition("friction not compensated", compensated=False),
    Condition("no friction", friction=False),
)
"""Conditions of the tables; the last two apply to arms with friction only."""
