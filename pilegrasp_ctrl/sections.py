"""The tables of a scenario: every key with its default, range and meaning."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

Text = Annotated[str, Field(pattern=r"^[^\x00-\x1f\x7f]*$")]
Name = Annotated[Text, Field(min_length=1)]
Slope = Annotated[float, Field(ge=0.0, le=90.0)]
MASS_RANGE = (1e-3, 5.0)
"""Range of an object's mass [kg], chosen."""

Mass = Annotated[float, Field(ge=MASS_RANGE[0], le=MASS_RANGE[1])]
FrameSize = Annotated[float, Field(gt=0.0, le=1.0)]
Share = Annotated[float, Field(ge=0.0, le=0.5)]
Gain = Annotated[float, Field(ge=0.0, le=4.0)]
Factor = Annotated[float, Field(ge=0.2, le=5.0)]
Noise = Annotated[float, Field(ge=0.0, le=10.0)] | None
Calibration = Literal["SI-32-2.5", "SI-65-5", "SI-130-10"]
Coordinate = Annotated[float, Field(ge=-2.0, le=2.0)]
Vector = tuple[Coordinate, Coordinate, Coordinate]


class Section(BaseModel):
    """A table of a scenario. It is frozen, and rejects unknown keys and numbers that are not finite."""

    model_config = ConfigDict(frozen=True, extra="forbid", validate_default=True, allow_inf_nan=False)

    def changed(self) -> list[str]:
        """Return the names of the fields that differ from their defaults."""
        return [name for name, field in type(self).model_fields.items() if getattr(self, name) != field.default]


class SupportConfig(Section):
    """The support beside the pile."""

    kind: Literal["none", "wall", "corner"] = Field(default="wall", description="support behind the pile")
    tilt_deg: float = Field(default=0.0, ge=0.0, le=15.0, description="slope of the floor toward the support [deg]")
    slope_error_deg: float = Field(
        default=0.0, ge=-3.0, le=3.0, description="unknown additional rise of the floor toward the support [deg]"
    )
    bin: bool = Field(
        default=False, description="whether the support belongs to a crate of 0.56 x 0.38 x 0.16 m inside"
    )

    @model_validator(mode="after")
    def _something_to_push_to(self) -> SupportConfig:
        if self.kind == "none" and (self.bin or self.tilt_deg > 0.0 or self.slope_error_deg != 0.0):
            why = "a bin is pushed to its wall or corner" if self.bin else "on a sloped floor the objects roll away"
            slope = "support.tilt_deg" if self.tilt_deg > 0.0 else "support.slope_error_deg"
            raise PydanticCustomError(
                "idle",
                "support.kind = 'none' is not allowed, because {why}; make it 'wall' or 'corner'",
                {"key": "support.bin" if self.bin else slope, "why": why},
            )
        return self

    @model_validator(mode="after")
    def _a_bin_stands_as_it_is_known(self) -> SupportConfig:
        if self.bin and self.slope_error_deg != 0.0:
            raise PydanticCustomError(
                "idle",
                "support.slope_error_deg is for an open table, because the pose of a bin is known; leave it out",
                {"key": "support.slope_error_deg"},
            )
        return self


class PileConfig(Section):
    """The objects, and the frame into which they are dropped."""

    object: Text = Field(
        default="light_sphere",
        description="object: a name, or a TOML file of your own; several, joined by +, take turns",
    )
    variant: Literal["real", "sim", "literal"] = Field(
        default="real", description="size: the real or the simulated one of Table I, or its r taken literally as radius"
    )
    count: int = Field(default=18, ge=0, le=200, description="number of objects; every object in a net counts")
    mass: Mass | None = Field(default=None, description="mass of one object; that of its model if absent [kg]")
    scale: float = Field(default=1.0, ge=0.25, le=4.0, description="factor on the object's lengths")
    friction: float = Field(
        default=1.0, ge=0.0, le=3.0, description="factor on the objects' friction: sliding, spinning and rolling"
    )
    frame_size: FrameSize | None = Field(
        default=None, description="inner side of the dropping frame; derived from the count if absent [m]"
    )


class HandModelConfig(Section):
    """Factors on the uncertain numbers of the hand's `robot.toml`, for sweeps; 1 keeps the shipped number."""

    bending_stiffness: Factor = Field(default=1.0, description="factor on the springs that bend the fingers")
    inflation_stiffness: Gain | None = Field(
        default=None, description="share of the bending stiffness that inflation adds; that of the hand if absent"
    )
    lateral_stiffness: Factor = Field(default=1.0, description="factor on the sideways springs at the fingers' bases")
    damping: Factor = Field(default=1.0, description="factor on the damping of bending and sideways motion")
    closing_moment: Factor = Field(default=1.0, description="factor on the moments of inflation, thumb included")
    time_constant: Factor = Field(default=1.0, description="factor on the time constant of inflation")
    fingertip_radius: float = Field(default=1.0, ge=0.5, le=2.5, description="factor on the radius of the fingertips")
    preshape: float = Field(default=1.0, ge=0.0, le=2.5, description="factor on the closure during the push")
    friction: Factor = Field(default=1.0, description="factor on the sliding friction of the hand's skin")
    restitution: float = Field(default=1.0, ge=0.0, le=1.25, description="factor on the restitution of the hand's skin")
    sensor_mass: Factor = Field(default=1.0, description="factor on the mass of the force/torque sensor")

    def pneumatic(self) -> list[str]:
        """Return the names of the changed factors that have no effect on a rigid hand."""
        return [name for name in self.changed() if name not in ("friction", "restitution", "sensor_mass")]


class StrategyConfig(Section):
    """The strategy: aim of the hand, angles as in the paper's Fig. 3, speeds and thresholds."""

    kind: Literal["pile", "object"] = Field(
        default="pile", description="aim of the hand: the pile's centre, or a chosen object"
    )
    alpha_deg: float = Field(default=0.0, ge=-90.0, le=90.0, description="orientation of the hand to the pile [deg]")
    beta_deg: float = Field(default=0.0, ge=-60.0, le=60.0, description="offset of the fingers from the motion [deg]")
    theta_deg: Slope | None = Field(default=None, description="slope of the fingers; that of the hand if absent [deg]")
    speed: float = Field(default=0.1, ge=0.01, le=0.7, description="speed of the push, |v_hand| [m/s]")
    grasp_force: float = Field(
        default=17.0, ge=0.5, le=200.0, description="force along the push that ends it, F_grasp [N]"
    )
    touch_force: float = Field(default=1.8, ge=0.5, le=20.0, description="vertical force that ends the approach [N]")
    approach_speed: float = Field(
        default=0.15, ge=0.02, le=0.5, description="speed of the approach in free space [m/s]"
    )
    touch_speed: float = Field(default=0.05, ge=0.005, le=0.2, description="speed of lowering onto the table [m/s]")
    lift_height: float = Field(default=0.2, ge=0.05, le=0.4, description="height of the lift after the grasp [m]")
    clearance: float = Field(
        default=0.05, ge=0.0, le=0.2, description="distance of the touch-down to the pile's edge [m]"
    )


class OrderConfig(Section):
    """An order from the bin, for `program = "order"`."""

    count: int = Field(default=4, ge=1, le=50, description="number of objects to deliver; a net-bag counts as one")
    max_attempts: int = Field(default=30, ge=1, le=100, description="largest number of attempts")


class LineConfig(Section):
    """A straight line in free space, for `program = "line"`."""

    start: Vector = Field(default=(0.55, -0.15, 0.25), description="first position of the tool in the scene [m]")
    displacement: Vector = Field(
        default=(0.0, 0.3, 0.0), description="displacement from the first to the last position [m]"
    )
    speed: float = Field(default=0.1, ge=0.005, le=1.0, description="speed along the line [m/s]")


class ControllerConfig(Section):
    """The controller, its gains, solver and rate."""

    kind: Literal["operational_space", "impedance"] | None = Field(
        default=None, description="controller; that of the hand if absent"
    )
    gains: Name | None = Field(default=None, description="TOML file of gains; the shipped gains if absent")
    solver: Literal["daqp", "osqp", "proxqp", "quadprog"] = Field(
        default="daqp", description="solver of the quadratic program"
    )
    rate: float = Field(default=500.0, ge=100.0, le=2000.0, description="control rate [Hz]")
    compiled: bool = Field(
        default=False,
        description="whether operational-space control is compiled; it needs numba and changes the last digits",
    )


class SensorConfig(Section):
    """The wrist force/torque sensor; `docs/sensor.md` gives the source of each number."""

    cutoff: float = Field(default=8.0, ge=0.1, le=1000.0, description="corner of the first-order low-pass [Hz]")
    force_noise: Noise = Field(
        default=None, description="standard deviation of the force noise; range of Fx / 1300 if absent [N]"
    )
    torque_noise: Noise = Field(
        default=None, description="standard deviation of the torque noise; range / 2500 if absent [N·m]"
    )
    calibration: Calibration = Field(
        default="SI-130-10", description="calibration of the ATI Gamma, which sets range and resolution"
    )
    bias: Share = Field(default=0.01, description="largest constant offset, as a share of the range")
    drift: Share = Field(default=0.001, description="largest drift in a minute, as a share of the range [1/min]")
    tool_mass_error: float = Field(default=0.0, ge=-0.5, le=0.5, description="error of the tool's mass, as a share")

    @model_validator(mode="after")
    def _noise_of_the_calibration(self) -> SensorConfig:
        """Fill in absent noise by the ranges in the calibration's name, so that hash and recording hold its values."""
        force, torque = map(float, self.calibration.split("-")[1:])
        noise = {"force_noise": force / 1300.0, "torque_noise": torque / 2500.0}
        self.__dict__.update({key: value for key, value in noise.items() if getattr(self, key) is None})
        return self


class SimulationConfig(Section):
    """Numerics of the simulation."""

    timestep: float = Field(default=0.001, ge=1e-4, le=2e-3, description="step of the physics [s]")
    contact_rule: Literal["paper", "product", "maximum"] = Field(
        default="paper", description="rule that combines friction and restitution of two bodies"
    )
