"""The `robot.toml` of a hand: its keys, and what the hand can do with the objects."""

from __future__ import annotations

import copy
import json
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from .exceptions import ModelError, remedy_for
from .problems import allowed_values
from .sections import HandModelConfig, Name, Section

Ability = Literal["close", "scoop", "release"]
"""What a hand can do: close on the objects, tilt back under them, or open over a crate so that they leave it."""

SCALED = {
    "bending_stiffness": ("pneumatics.bending_stiffness",),
    "lateral_stiffness": ("pneumatics.lateral_stiffness",),
    "twist_stiffness": ("pneumatics.twist_stiffness",),
    "damping": ("pneumatics.bending_damping", "pneumatics.lateral_damping"),
    "closing_moment": ("pneumatics.closing_moment", "pneumatics.thumb_closing_moment"),
    "time_constant": ("pneumatics.time_constant",),
    "fingertip_radius": ("fingers.radius_tip",),
    "pad_give": ("pad.give",),
    "preshape": ("use.preshape",),
    "friction": ("surface.lateral",),
    "restitution": ("surface.restitution",),
    "sensor_mass": ("sensor.mass",),
}
"""Numbers of `robot.toml` that each factor of `hand_model` multiplies."""

REPLACED = {"inflation_stiffness": "pneumatics.inflation_stiffness", "advance": "use.advance"}
"""Number of `robot.toml` that a key of `hand_model` replaces. A factor would not do, because the number can be 0."""

OWN_TABLES = ("hand", "sensor", "surface", "pad", "touch", "use", "collision")
"""Tables that every hand may have. Further tables are the parameters of its builder."""

BUILDER_PARAMETERS = ("spec", "root", "parameters")
"""Parameters of a builder: a `mujoco.MjSpec`, its body `sensor` in the flange's frame, and the tables of `robot.toml`.
The builder adds the hand's bodies to that body."""

Length = Annotated[float, Field(ge=-1.0, le=1.0)]
Point = tuple[Length, Length, Length]
Angle = Annotated[float, Field(ge=-180.0, le=180.0)]
Amount = Annotated[float, Field(ge=0.0, le=5.0)]


class MountTable(Section):
    """The model of a hand, its tool frame and its slope."""

    mjcf: Name | None = Field(default=None, description="MJCF in the folder; its origin is on the sensor's outer face")
    builder: Name | None = Field(default=None, description="function module:function that adds the bodies, in Python")
    mount_deg: Angle = Field(default=0.0, description="turn of the MJCF about the flange's axis [deg]")
    tool_frame: Name | None = Field(
        default=None, description="site: origin in the middle of the leading edge, x along fingers or floor, z up"
    )
    tool_origin: Point | None = Field(default=None, description="in place of tool_frame: its origin in the flange [m]")
    finger_angle_deg: Angle = Field(
        default=0.0, description="with tool_origin: angle from the flange's axis to the fingers, toward its -x [deg]"
    )
    theta_deg: float = Field(ge=0.0, le=90.0, description="slope of fingers or floor against the table [deg]")
    controller: Literal["operational_space", "impedance"] = Field(
        default="operational_space", description="default controller; a rigid edge that slides needs impedance"
    )
    width: float | None = Field(
        default=None, gt=0.0, le=1.0, description="width in which it meets objects; from the geometry if absent [m]"
    )
    contact_geoms: tuple[Name, ...] | None = Field(
        default=None, description="geoms that touch; if absent, all that may collide in the model"
    )

    @model_validator(mode="after")
    def _one_model_and_one_tool_frame(self) -> MountTable:
        for one, other in (("mjcf", "builder"), ("tool_frame", "tool_origin")):
            if (getattr(self, one) is None) == (getattr(self, other) is None):
                raise PydanticCustomError("idle", "needs one of {one} and {other}", {"one": one, "other": other})
        return self


class SensorTable(Section):
    """The force/torque sensor between flange and hand, a cylinder about the flange's axis; by default an ATI Gamma."""

    mass: float = Field(default=0.255, ge=0.0, le=5.0, description="mass [kg]")
    radius: float = Field(default=0.043, gt=0.0, le=0.5, description="radius [m]")
    bottom: Length = Field(default=-0.003, description="end toward the arm, along the flange's axis [m]")
    top: Length = Field(default=0.049, description="outer face [m]")


class SurfaceTable(Section):
    """Friction and restitution of the hand."""

    lateral: Amount = Field(description="sliding friction [-]")
    spinning: Amount = Field(default=0.001, description="torsional friction [m]")
    rolling: Amount = Field(default=0.001, description="rolling friction [m]")
    restitution: float = Field(default=0.1, ge=0.0, le=1.0, description="restitution [-]")
    contact_time: float = Field(
        default=0.01,
        ge=0.0,
        le=0.02,
        description="duration of a bounce; 0 for steel and wood, about 0.01 for rubber [s]",
    )


class PadTable(Section):
    """A soft skin, such as rubber, on some geoms of the hand."""

    give: float = Field(default=0.0, ge=0.0, le=0.02, description="depth of a contact under 5 N at rest [m]")
    geoms: tuple[Name, ...] = Field(default=(), description="names of the soft geoms; * stands for any characters")

    @model_validator(mode="after")
    def _a_pad_is_somewhere(self) -> PadTable:
        if (self.give > 0.0) != bool(self.geoms):
            raise PydanticCustomError("idle", "pad.give and pad.geoms belong together: give both or none")
        return self


class TouchTable(Section):
    """Which parts of the hand touch one another. What its MJCF says of contacts does not count."""

    pairs: tuple[tuple[Name, Name], ...] = Field(
        default=(), description="pairs of geoms that touch; * stands for any characters of a name"
    )


class UseTable(Section):
    """How the primitives use the hand."""

    can: tuple[Ability, ...] = Field(default=(), description="what the hand can do; nothing for a plate that pushes")
    preshape: float = Field(default=0.0, ge=0.0, le=1.0, description="closure until the end of the push [-]")
    press_depth: float = Field(default=0.0, ge=0.0, le=0.05, description="push's reference below touch-down [m]")
    normal_force: float = Field(default=0.0, ge=0.0, le=100.0, description="force on the support in the push [N]")
    closing_time: float = Field(default=0.0, ge=0.0, le=30.0, description="time that closing takes [s]")
    closing_force: float | None = Field(
        default=None, gt=0.0, le=1000.0, description="largest force of each closing actuator; the model's if absent [N]"
    )
    stroke_time: float = Field(
        default=0.0, ge=0.0, le=30.0, description="least time from open to closed; 0 if the model limits it [s]"
    )
    closure: dict[Name, tuple[float, float]] = Field(
        default={}, description="control of an actuator when open and closed; the ends of its ctrlrange if absent"
    )
    advance: float = Field(
        default=0.0, ge=0.0, le=0.5, description="longest way that the hand goes on along the push while it closes [m]"
    )
    scoop_angle_deg: float = Field(default=0.0, ge=0.0, le=90.0, description="tilt back before the lift [deg]")
    aim_width: float | None = Field(
        default=None,
        gt=0.0,
        le=1.0,
        description="width in which objects count when lines in a bin are compared; hand.width if absent [m]",
    )
    heel: float | None = Field(
        default=None, ge=0.0, le=1.0, description="leading edge to heel; from the geometry if absent [m]"
    )
    payload: float | None = Field(
        default=None, gt=0.0, le=100.0, description="largest mass that the hand was measured to hold [kg]"
    )

    @model_validator(mode="after")
    def _every_ability_has_its_numbers(self) -> UseTable:
        for ability, key in (("close", "closing_time"), ("scoop", "scoop_angle_deg")):
            if (ability in self.can) != (getattr(self, key) > 0.0):
                raise PydanticCustomError(
                    "idle", "{key} goes with '{ability}' in can: give both or none", {"key": key, "ability": ability}
                )
        if {"close", "scoop"} <= set(self.can):
            raise PydanticCustomError("idle", "can must hold 'close' or 'scoop', which both end the push, not both")
        return self


class HandDescription(Section):
    """The checked tables of a hand's `robot.toml`, without the parameters of a builder."""

    hand: MountTable
    sensor: SensorTable = SensorTable()
    surface: SurfaceTable
    pad: PadTable = PadTable()
    touch: TouchTable = TouchTable()
    use: UseTable
    collision: dict[str, Any] = Field(default={}, description="capsules of a controller that keeps off crates")

    @classmethod
    def of(cls, parameters: Mapping[str, Any], label: str) -> HandDescription:
        """Check the parsed `robot.toml` of a hand.

        Args:
            parameters: Parsed file.
            label: Name of the hand, for the error.

        Raises:
            ModelError: A key is missing, unknown or out of its range.
        """
        own = {name: table for name, table in parameters.items() if name in OWN_TABLES}
        mount = own.get("hand")
        if not (isinstance(mount, Mapping) and "builder" in mount):
            own = dict(parameters)
        try:
            return cls.model_validate_json(json.dumps(own), strict=True)
        except ValidationError as error:
            raise ModelError(f"{label}: in its robot.toml {_sentence(error.errors()[0])}") from None
        except (TypeError, ValueError, RecursionError):
            raise ModelError(f"{label}: its robot.toml holds a value that is no number, text, list or table") from None


def vary(parameters: Mapping[str, Any], model: HandModelConfig) -> dict[str, Any]:
    """Return a copy of a hand's parameters with the changes of `model`."""
    result = copy.deepcopy(dict(parameters))
    for change in model.changed():
        value = getattr(model, change)
        for name in SCALED.get(change, ()):
            table, _, key = name.partition(".")
            if key in result.get(table, {}):
                result[table][key] *= value
        if change in REPLACED:
            table, _, key = REPLACED[change].partition(".")
            result.setdefault(table, {})[key] = value
    return result


def idle_changes(parameters: Mapping[str, Any], model: HandModelConfig) -> list[str]:
    """Return the changes of `model` that have no effect on a hand, because it lacks the numbers or does not close."""
    return [name for name in model.changed() if not _has_effect(name, parameters)]


def abilities_of(parameters: Mapping[str, Any]) -> Sequence[str]:
    """Return what a hand can do, from its `robot.toml`, which need not be checked yet."""
    use = parameters.get("use")
    can = use.get("can") if isinstance(use, Mapping) else None
    return can if isinstance(can, list) else []


def _has_effect(change: str, parameters: Mapping[str, Any]) -> bool:
    if change in ("preshape", "advance"):
        return "close" in abilities_of(parameters)
    numbers = [number.partition(".") for number in SCALED.get(change) or (REPLACED[change],)]
    # Sensor and surface have defaults, which may be varied, too.
    return any(table in ("sensor", "surface") or key in (parameters.get(table) or ()) for table, _, key in numbers)


def _sentence(problem: Any) -> str:
    """Return what is wrong with a key, and what is allowed."""
    key, fault, message = ".".join(str(part) for part in problem["loc"]), problem["type"], str(problem["msg"])
    if fault == "idle":
        return f"[{key}] {message}" if "." not in key and key else message
    if fault == "missing":
        return f"{key} is missing; add it"
    if fault == "extra_forbidden":
        known = _known_keys(key.split(".")[:-1])
        return f"{key} is not known; {remedy_for(key.split('.')[-1], known, 'the keys are ' + ', '.join(known))}"
    return f"{key} = {problem['input']!r:.80} is not allowed: {allowed_values(fault, message)}"


def _known_keys(path: list[str]) -> list[str]:
    section: Any = HandDescription
    for name in path:
        section = section.model_fields[name].annotation
    return list(section.model_fields)
