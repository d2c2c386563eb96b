"""What is wrong with the plant, the sensors or the controller while tracking is measured: one thing at a time."""

from __future__ import annotations

from dataclasses import dataclass

from example_arm import ExampleArm
from pilegrasp_ctrl.arm.model import ArmModel
from pilegrasp_ctrl.control.operational_space import OperationalSpaceController
from pilegrasp_ctrl.plant.arm_simulation import ArmSimulation


@dataclass(frozen=True, slots=True)
class Condition:
    """One departure from a plant that is as its model says.

    Attributes:
        name: as it stands in the table.
        mass_factor: of the plant's links against the model's.
        payload: that the model does not know, at the tool frame's origin [kg].
        noisy: whether the controller sees encoders' noise.
        friction: whether the plant's joints rub as the model says; the controller then compensates it.
        compensated: whether the controller feeds friction forward.
    """

    name: str
    mass_factor: float = 1.0
    payload: float = 0.0
    noisy: bool = False
    friction: bool = True
    compensated: bool = True

    def concerns(self, arm: ArmModel) -> bool:
        """Whether the condition differs from the nominal one for an arm; those about friction need some."""
        rubs = bool(arm.friction_coulomb.any() or arm.friction_viscous.any())
        return rubs or (self.friction and self.compensated)

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
"""The last two concern arms with friction only."""
