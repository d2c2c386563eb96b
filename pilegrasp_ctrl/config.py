"""Validated scenarios: what a TOML file or `--set key=value` may say, and what it means."""

from __future__ import annotations

import hashlib
import json
import tomllib
from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from .exceptions import ConfigurationError
from .scenarios import find

Positive = Annotated[float, Field(gt=0.0)]
NonNegative = Annotated[float, Field(ge=0.0)]
Slope = Annotated[float, Field(ge=0.0, le=90.0)]
Vector = tuple[float, float, float]


class Section(BaseModel):
    """Frozen; an unknown key is an error, and so is a number that is not finite."""

    model_config = ConfigDict(frozen=True, extra="forbid", validate_default=True, allow_inf_nan=False)


class SupportConfig(Section):
    """What stands beside the pile."""

    kind: Literal["none", "wall", "corner"] = Field(default="wall", description="what stands behind the pile")
    tilt_deg: float = Field(default=0.0, ge=0.0, le=15.0, description="slope of the floor toward the support [deg]")


class PileConfig(Section):
    """The objects and the frame they are dropped into."""

    object: str = Field(default="light_sphere", description="kind of object")
    count: int = Field(default=18, ge=0, le=200, description="number of objects")
    mass: Positive | None = Field(default=None, description="mass of one object; the kind's own where absent [kg]")
    scale: float = Field(default=1.0, gt=0.0, le=4.0, description="factor on the object's lengths")
    frame_size: Positive | None = Field(
        default=None, description="inner side of the frame; by the count where absent [m]"
    )


class StrategyConfig(Section):
    """The pile-based strategy: angles as in the paper's Fig. 3, speed and thresholds."""

    kind: Literal["pile"] = Field(default="pile", description="whether the push heeds the pile alone")
    alpha_deg: float = Field(default=0.0, ge=-90.0, le=90.0, description="orientation of the hand to the pile [deg]")
    beta_deg: float = Field(default=0.0, ge=-60.0, le=60.0, description="offset of the fingers from the motion [deg]")
    theta_deg: Slope | None = Field(default=None, description="slope of the fingers; the hand's own where absent [deg]")
    speed: float = Field(default=0.1, gt=0.0, le=0.7, description="speed of the push, |v_hand| [m/s]")
    grasp_force: Positive = Field(default=17.0, description="force along the push that ends it, F_grasp [N]")
    touch_force: Positive = Field(default=1.8, description="vertical force that ends the approach [N]")
    approach_speed: float = Field(default=0.15, gt=0.0, le=0.5, description="speed in free space [m/s]")
    touch_speed: float = Field(default=0.05, gt=0.0, le=0.2, description="speed of lowering onto the table [m/s]")
    lift_height: float = Field(default=0.2, ge=0.05, le=0.4, description="height of the lift after the grasp [m]")
    clearance: float = Field(default=0.05, ge=0.0, le=0.2, description="fingertips to the pile's edge at first [m]")


class LineConfig(Section):
    """A straight line in free space, for `program = "line"`."""

    start: Vector = Field(default=(0.55, -0.15, 0.25), description="first position of the tool in the scene [m]")
    displacement: Vector = Field(default=(0.0, 0.3, 0.0), description="from the first to the last position [m]")
    speed: float = Field(default=0.1, gt=0.0, le=1.0, description="speed along the line [m/s]")


class ControllerConfig(Section):
    """Which controller, its gains and its rate."""

    kind: Literal["operational_space", "impedance"] | None = Field(
        default=None, description="which controller; the hand's own where absent"
    )
    gains: str | None = Field(default=None, description="TOML file of gains; the shipped ones where absent")
    solver: Literal["daqp", "osqp"] = Field(default="daqp", description="solver of the quadratic program")
    rate: float = Field(default=500.0, ge=100.0, le=2000.0, description="control ticks per second [Hz]")


class SensorConfig(Section):
    """The wrist force/torque sensor."""

    cutoff: Positive = Field(default=8.0, description="corner of the first-order low-pass [Hz]")
    force_noise: NonNegative = Field(default=0.05, description="standard deviation of a force sample [N]")
    torque_noise: NonNegative = Field(default=0.002, description="standard deviation of a torque sample [N·m]")


class SimulationConfig(Section):
    """Numerics of the simulation."""

    timestep: float = Field(default=0.001, ge=1e-4, le=2e-3, description="step of the physics [s]")
    contact_rule: Literal["paper", "product", "maximum"] = Field(
        default="paper", description="how the restitutions of two bodies combine"
    )


class Scenario(Section):
    """One attempt, completely described; together with a seed it fixes the result."""

    name: str = Field(default="unnamed", description="the file's own name where absent")
    summary: str = Field(default="", description="one line for `pilegrasp list`")
    tags: tuple[str, ...] = Field(default=(), description="words for `pilegrasp list --tag`")
    program: Literal["grasp", "push", "line"] = Field(
        default="grasp", description="sequence of primitives that is carried out"
    )
    robot: str = Field(default="wam7", description="arm: a folder of `robots/`")
    hand: Literal["rbo_hand2", "shovel"] = Field(default="rbo_hand2", description="end-effector")
    support: SupportConfig = SupportConfig()
    pile: PileConfig = PileConfig()
    strategy: StrategyConfig = StrategyConfig()
    line: LineConfig = LineConfig()
    controller: ControllerConfig = ControllerConfig()
    sensor: SensorConfig = SensorConfig()
    sim: SimulationConfig = SimulationConfig()

    def config_hash(self) -> str:
        """Return 16 hex digits that are equal where the physics and the control are asked to be equal.

        The name, the summary and the tags do not enter; the file of gains enters with its content.

        Raises:
            ConfigurationError: where that file cannot be read.
        """
        content = self.model_dump(mode="json", exclude={"name", "summary", "tags"})
        if self.controller.gains is not None:
            content["controller"]["gains"] = hashlib.sha256(_read(Path(self.controller.gains))).hexdigest()
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


def dotted_keys(section: type[Section] = Scenario, prefix: str = "") -> list[str]:
    """Return every key that `--set` takes, in the order of the declaration."""
    keys: list[str] = []
    for name, field in section.model_fields.items():
        kind = field.annotation
        if isinstance(kind, type) and issubclass(kind, Section):
            keys += dotted_keys(kind, f"{prefix}{name}.")
        else:
            keys.append(prefix + name)
    return keys


def parse_overrides(texts: Iterable[str]) -> dict[str, Any]:
    """Read `key=value` texts; a value is TOML where it parses as TOML and a bare string otherwise.

    Raises:
        ConfigurationError: where a text has no `=` or no key.
    """
    overrides: dict[str, Any] = {}
    for text in texts:
        key, separator, value = text.partition("=")
        if not separator or not key.strip():
            raise ConfigurationError(f"--set {text!r} is not of the form key=value, for example --set pile.count=5")
        try:
            overrides[key.strip()] = tomllib.loads(f"value = {value}")["value"]
        except tomllib.TOMLDecodeError:
            overrides[key.strip()] = value.strip()
    return overrides


def build_scenario(
    table: Mapping[str, Any], overrides: Mapping[str, Any] | None = None, source: str = "scenario"
) -> Scenario:
    """Validate a nested table and dotted overrides.

    Raises:
        ConfigurationError: one sentence that names the source, the key and what is allowed.
    """
    merged: dict[str, Any] = json.loads(_to_json(table, source))
    valid = dotted_keys()
    for key, value in (overrides or {}).items():
        if key not in valid:
            raise ConfigurationError(f"{source}: unknown key {key!r}; {_suggest(key, valid)}")
        *path, leaf = key.split(".")
        place = merged
        for part in path:
            place = place.setdefault(part, {})
            if not isinstance(place, dict):
                raise ConfigurationError(f"{source}: {part!r} must be a table")
        place[leaf] = value
    try:
        return Scenario.model_validate_json(_to_json(merged, source), strict=True)
    except ValidationError as error:
        raise ConfigurationError(f"{source}: {_sentence(error, valid)}") from error


def load_scenario(name: str | Path, overrides: Mapping[str, Any] | None = None) -> Scenario:
    """Read a scenario: the name of one that ships, or a TOML file.

    A file of gains is looked for beside the scenario's own file; one in `overrides`, in the working directory.

    Raises:
        ConfigurationError: where nothing has that name, or the file is missing, is not TOML, or does not validate.
    """
    path = find(name)
    try:
        table = tomllib.loads(_read(path).decode("utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ConfigurationError(f"{path}: is not valid TOML: {error}") from None
    table.setdefault("name", path.stem)
    controller = table.get("controller")
    if isinstance(controller, dict) and isinstance(controller.get("gains"), str):
        controller["gains"] = str(path.parent / controller["gains"])
    return build_scenario(table, overrides, source=str(path))


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except FileNotFoundError:
        raise ConfigurationError(f"{path}: no such file") from None
    except OSError as error:
        raise ConfigurationError(f"{path}: cannot be read: {error.strerror}") from None


def _to_json(value: Any, source: str) -> str:
    try:
        return json.dumps(value, default=lambda other: str(other) if isinstance(other, Path) else other.tolist())
    except (AttributeError, TypeError, ValueError) as error:
        raise ConfigurationError(f"{source}: holds a value that is no number, text, list or table ({error})") from None


def _suggest(key: str, valid: list[str]) -> str:
    close = get_close_matches(key, valid, n=1)
    if close:
        return f"did you mean {close[0]!r}?"
    section = key.partition(".")[0] + "."
    return f"valid keys are {', '.join([name for name in valid if name.startswith(section)] or valid)}"


def _sentence(error: ValidationError, valid: list[str]) -> str:
    parts = []
    for problem in error.errors():
        key = ".".join(str(part) for part in problem["loc"])
        if problem["type"] == "extra_forbidden":
            parts.append(f"unknown key {key!r}; {_suggest(key, valid)}")
        else:
            allowed = problem["msg"].lower().replace("an object", "a table")
            parts.append(f"{key} = {problem['input']!r} is not allowed: {allowed}")
    return "; ".join(parts)
