"""The tables of a scenario: every key with its default, range and meaning."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from .provenance import SOLVER_PACKAGES

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
Advance = Annotated[float, Field(ge=0.0, le=0.2)]
Calibration = Literal["SI-32-2.5", "SI-65-5", "SI-130-10"]
Coordinate = Annotated[float, Field(ge=-2.0, le=2.0)]
Vector = tuple[Coordinate, Coordinate, Coordinate]
Point = tuple[Coordinate, Coordinate]
Side = Annotated[float, Field(ge=0.1, le=1.5)]
WallHeight = Annotated[float, Field(ge=0.02, le=0.4)]
Thickness = Annotated[float, Field(ge=0.001, le=0.05)]
CrateSize = tuple[Side, Side, WallHeight]

IFCO_SIZE = (0.56, 0.38, 0.16)
"""Inner length, width and height of the IFCO crate in the authors' laboratory (their vision's `ifco.yaml`) [m]."""

IFCO_THICKNESS = (0.0175, 0.0075)
"""Thickness of its short and of its long walls [m]; the laboratory's model measures 0.595 x 0.395 m outside."""

ORDER_SIZE = (0.38, 0.28, 0.16)
"""Inner length, width and height of the crate that collects an order [m]; chosen, half as large as the bin."""


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
        default=False, description="whether the support belongs to a bin; another `support.bin_size` alone means `true`"
    )
    bin_size: CrateSize = Field(
        default=IFCO_SIZE, description="inner length (from the arm away), width and height of the bin [m]"
    )
    bin_wall_heights: tuple[WallHeight, WallHeight, WallHeight, WallHeight] | None = Field(
        default=None, description="heights of the far, near, left and right wall; those of `bin_size` if absent [m]"
    )
    bin_thickness: tuple[Thickness, Thickness] = Field(
        default=IFCO_THICKNESS, description="thickness of the far and near, and of the left and right walls [m]"
    )
    bin_position: Point | None = Field(
        default=None,
        description="middle of the bin's floor, seen from the arm's axis; straight ahead if absent [m]",
    )
    bin_yaw_deg: float = Field(
        default=0.0, ge=-90.0, le=90.0, description="rotation of the bin about its middle, to the left [deg]"
    )

    @model_validator(mode="after")
    def _a_size_means_a_bin(self) -> SupportConfig:
        if self.bin_size != IFCO_SIZE and "bin" not in self.model_fields_set:
            self.__dict__["bin"] = True
        return self

    @model_validator(mode="after")
    def _a_bin_has_walls(self) -> SupportConfig:
        for key in self.changed() if not self.bin else ():
            if key.startswith("bin_"):
                raise PydanticCustomError(
                    "idle",
                    "{key} has no effect without a bin; leave it out, or make support.bin = true",
                    {"key": f"support.{key}"},
                )
        return self

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


class KnownConfig(Section):
    """What the arm believes against what it is: believed minus true, in the axes of the scene."""

    table_z: float = Field(default=0.0, ge=-0.03, le=0.03, description="believed height of the table, minus true [m]")
    support_x: float = Field(
        default=0.0, ge=-0.1, le=0.1, description="believed place of the support along x, minus true [m]"
    )
    support_y: float = Field(
        default=0.0, ge=-0.1, le=0.1, description="believed place of the support along y, minus true [m]"
    )
    support_yaw_deg: float = Field(
        default=0.0, ge=-20.0, le=20.0, description="believed yaw of the support, minus true [deg]"
    )
    pile_x: float = Field(
        default=0.0, ge=-0.1, le=0.1, description="believed place of the objects along x, minus true [m]"
    )
    pile_y: float = Field(
        default=0.0, ge=-0.1, le=0.1, description="believed place of the objects along y, minus true [m]"
    )


class SpreadConfig(Section):
    """How much the objects of one kind differ; each factor is drawn from the seed, uniformly about 1."""

    size: Share = Field(default=0.0, description="largest deviation of an object's lengths, as a share")
    mass: Share = Field(default=0.0, description="largest deviation of an object's mass, as a share")
    friction: Share = Field(default=0.0, description="largest deviation of an object's friction, as a share")


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
    friction_value: float | None = Field(
        default=None, ge=0.0, le=3.0, description="sliding friction of all objects, before the factor; own if absent"
    )
    mutual_contacts: bool = Field(
        default=True, description="whether the objects touch one another after they have been dropped"
    )
    frame_size: FrameSize | None = Field(
        default=None, description="inner side of the dropping frame; derived from the count if absent [m]"
    )
    spread: SpreadConfig = SpreadConfig()
    frame_position: Point | None = Field(
        default=None,
        description="middle of the dropping frame, seen from the middle of the bin; at the support if absent [m]",
    )


class HandModelConfig(Section):
    """Changes of the uncertain numbers of the hand's `robot.toml`, for sweeps; a factor of 1 keeps the number."""

    bending_stiffness: Factor = Field(default=1.0, description="factor on the springs that bend the fingers")
    inflation_stiffness: Gain | None = Field(
        default=None, description="share of the bending stiffness that inflation adds; that of the hand if absent"
    )
    lateral_stiffness: Factor = Field(default=1.0, description="factor on the sideways springs at the fingers' bases")
    twist_stiffness: Factor = Field(
        default=1.0, description="factor on the springs against torsion at the fingers' bases"
    )
    damping: Factor = Field(default=1.0, description="factor on the damping of bending and sideways motion")
    closing_moment: Factor = Field(default=1.0, description="factor on the moments of inflation, thumb included")
    time_constant: Factor = Field(default=1.0, description="factor on the time constant of inflation")
    fingertip_radius: float = Field(default=1.0, ge=0.4, le=2.5, description="factor on the radius of the fingertips")
    pad_give: Factor = Field(default=1.0, description="factor on the depth by which the soft skin gives way")
    preshape: float = Field(default=1.0, ge=0.0, le=2.5, description="factor on the closure during the push")
    friction: Factor = Field(default=1.0, description="factor on the sliding friction of the hand's skin")
    restitution: float = Field(default=1.0, ge=0.0, le=1.25, description="factor on the restitution of the hand's skin")
    sensor_mass: Factor = Field(default=1.0, description="factor on the mass of the force/torque sensor")
    advance: Advance | None = Field(
        default=None,
        description="longest way that the hand goes on along the push while it closes; that of the hand if absent [m]",
    )


class StrategyConfig(Section):
    """The strategy: aim of the hand, angles as in the paper's Fig. 3, speeds and thresholds."""

    kind: Literal["pile", "object"] = Field(
        default="pile", description="aim of the hand: the pile's centre, or a chosen object"
    )
    pushing_hand: Name | None = Field(
        default=None, description='hand that pushes in place of `hand`, which then closes, for `program = "swap"`'
    )
    alpha_deg: float = Field(default=0.0, ge=-90.0, le=90.0, description="orientation of the hand to the pile [deg]")
    beta_deg: float = Field(default=0.0, ge=-60.0, le=60.0, description="offset of the fingers from the motion [deg]")
    theta_deg: Slope | None = Field(default=None, description="slope of the fingers; that of the hand if absent [deg]")
    speed: float = Field(default=0.1, ge=0.01, le=0.7, description="speed of the push, |v_hand| [m/s]")
    grasp_force: float = Field(
        default=17.0, ge=0.5, le=200.0, description="force along the push that ends it, F_grasp [N]"
    )
    force_per_mass: float | None = Field(
        default=None,
        ge=1.0,
        le=2000.0,
        description="F_grasp over the mass of one object, in place of `grasp_force`; not used if absent [N/kg]",
    )
    close_on: Literal["force", "touches", "inside"] = Field(
        default="force",
        description="what ends the push: F_grasp alone, or also two objects that touch the fingers for 0.1 s, or one "
        "that touches a finger behind its tip for 0.1 s",
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

    @model_validator(mode="after")
    def _one_force_ends_the_push(self) -> StrategyConfig:
        if {"force_per_mass", "grasp_force"} <= set(self.changed()):
            raise PydanticCustomError(
                "idle",
                "strategy.force_per_mass takes the place of strategy.grasp_force; leave out one of the two",
                {"key": "strategy.force_per_mass"},
            )
        return self


class OrderConfig(Section):
    """An order from the bin, for `program = "order"`."""

    count: int = Field(default=4, ge=1, le=50, description="number of objects to deliver; a net-bag counts as one")
    max_attempts: int = Field(default=30, ge=1, le=100, description="largest number of attempts")
    operator: Name = Field(
        default="alternates",
        description='who chooses lines and counts: "sees", which knows every pose; "alternates" or "bandit", which '
        "know bin, hand, mass of a part and wrist sensor alone; or your own rule as module:function",
    )
    crate_size: CrateSize = Field(default=ORDER_SIZE, description="inner length, width and height of its crate [m]")
    crate_position: Point | None = Field(
        default=None,
        description="middle of its crate's floor in the axes of the bin, seen from the arm's axis; on the left of the "
        "bin if absent [m]",
    )


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
    solver: Literal[*SOLVER_PACKAGES] = Field(  # type: ignore[valid-type]
        default="daqp", description="solver of the quadratic program"
    )
    rate: float = Field(default=500.0, ge=100.0, le=2000.0, description="control rate [Hz]")
    keep_clear: bool = Field(
        default=False, description="whether limits of the controller keep arm and palm off the walls and rims of a bin"
    )
    compiled: bool = Field(
        default=False,
        description="without effect: the law of motion is always compiled",
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
    delay: float = Field(default=0.0, ge=0.0, le=0.1, description="time by which readings are late [s]")
    slow_drift: float = Field(
        default=0.0,
        ge=0.0,
        le=20.0,
        description="drift of the zero of the force after 10 s; it is back after 20 s [N]",
    )
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

    joint_friction: float = Field(
        default=1.0, ge=0.0, le=5.0, description="factor on the friction of the arm's joints, unknown to the controller"
    )
    arm_mass: float = Field(
        default=1.0, ge=0.5, le=1.5, description="factor on the mass of the arm's links, unknown to the controller"
    )
    timestep: float = Field(default=0.001, ge=1e-4, le=2e-3, description="step of the physics [s]")
    contact_rule: Literal["paper", "product", "maximum"] = Field(
        default="paper", description="rule that combines friction and restitution of two bodies"
    )
