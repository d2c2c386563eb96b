"""Scenarios: read from a TOML file and `--set key=value`, checked key by key, and hashed."""

from __future__ import annotations

import hashlib
import json
import tomllib
from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Any, Literal

from pydantic import Field, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from .exceptions import ConfigurationError
from .files import read_toml
from .scenarios import find, is_file, object_digests, object_parts
from .sections import (
    ControllerConfig,
    HandModelConfig,
    LineConfig,
    Name,
    OrderConfig,
    PileConfig,
    Section,
    SensorConfig,
    SimulationConfig,
    StrategyConfig,
    SupportConfig,
    Text,
)

_SECTIONS_OF = {"line": {"line"}, "order": {"strategy", "order"}}
"""Sections that a program reads; programs that are not listed read `strategy` alone."""

NEUTRAL_VALUES: dict[tuple[str, str], Any] = {("support", "slope_error_deg"): 0.0}
"""Values, by (section, key), of keys that were added after the kept study was made. Each value means the behaviour
before the key existed. `config_hash` leaves out a key that has this value, so that the study's hashes stay valid."""


class Scenario(Section):
    """Complete description of an attempt; together with a seed it fixes the result."""

    name: Name = Field(default="unnamed", description="name; that of the file if absent")
    summary: Text = Field(default="", description="one line for `pilegrasp list`")
    tags: tuple[Text, ...] = Field(default=(), description="tags for `pilegrasp list --tag`")
    program: Literal["grasp", "push", "line", "order"] = Field(default="grasp", description="sequence of primitives")
    robot: Name = Field(default="wam7", description="arm: a folder of `robots/`")
    hand: Literal["rbo_hand2", "shovel"] = Field(default="rbo_hand2", description="end-effector")
    hand_model: HandModelConfig = HandModelConfig()
    support: SupportConfig = SupportConfig()
    pile: PileConfig = PileConfig()
    strategy: StrategyConfig = StrategyConfig()
    line: LineConfig = LineConfig()
    order: OrderConfig = OrderConfig()
    controller: ControllerConfig = ControllerConfig()
    sensor: SensorConfig = SensorConfig()
    sim: SimulationConfig = SimulationConfig()

    @model_validator(mode="after")
    def _every_key_counts(self) -> Scenario:
        """Reject a value that the program or the hand does not read."""
        idle = {"strategy", "line", "order"} - _SECTIONS_OF.get(self.program, {"strategy"})
        for section in sorted(idle):
            for key in getattr(self, section).changed():
                raise PydanticCustomError(
                    "idle",
                    "{key} has no effect if program = '{program}'; leave it out",
                    {"key": f"{section}.{key}", "program": self.program},
                )
        if self.program == "line" and self.support.slope_error_deg != 0.0:
            raise PydanticCustomError(
                "idle",
                "{key} has no effect if program = 'line', which touches no floor; leave it out",
                {"key": "support.slope_error_deg"},
            )
        for key in self.hand_model.pneumatic() if self.hand == "shovel" else ():
            raise PydanticCustomError(
                "idle",
                "{key} has no effect if hand = 'shovel', which is rigid; leave it out",
                {"key": f"hand_model.{key}"},
            )
        return self

    @model_validator(mode="after")
    def _an_order_comes_from_a_bin(self) -> Scenario:
        """Reject an order without a bin, objects, or a hand that can release them."""
        if self.program == "order" and not (self.support.bin and self.hand == "rbo_hand2" and self.pile.count):
            wanted = "support.bin = true, hand = 'rbo_hand2', which can release objects, and pile.count of 1 or more"
            raise PydanticCustomError("idle", "program = 'order' needs {wanted}", {"key": "program", "wanted": wanted})
        return self

    def config_hash(self) -> str:
        """Return 16 hex digits that are equal for scenarios with the same physics and control.

        Name, summary and tags do not count. The files of gains and of the object count by their content.

        Raises:
            ConfigurationError: One of these files cannot be read.
        """
        content = self.model_dump(mode="json", exclude={"name", "summary", "tags"})
        for (section, key), value in NEUTRAL_VALUES.items():
            if content[section][key] == value:
                del content[section][key]
        if self.controller.gains is not None:
            content["controller"]["gains"] = hashlib.sha256(_read(Path(self.controller.gains))).hexdigest()
        if is_file(self.pile.object):
            parts = object_parts(self.pile.object)
            content["pile"]["object"] = [object_digests(Path(part)) if is_file(part) else part for part in parts]
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


def dotted_keys(section: type[Section] = Scenario, prefix: str = "") -> list[str]:
    """Return every key that `--set` takes, in the order of the declaration."""
    keys: list[str] = []
    for name, field in section.model_fields.items():
        declared = field.annotation
        if isinstance(declared, type) and issubclass(declared, Section):
            keys += dotted_keys(declared, f"{prefix}{name}.")
        else:
            keys.append(prefix + name)
    return keys


def parse_overrides(texts: Iterable[str]) -> dict[str, Any]:
    """Read `key=value` texts; a value that is not valid TOML is taken as a string.

    Raises:
        ConfigurationError: A text has no `=` or no key.
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
        ConfigurationError: A key or value cannot be used. The error names it and the allowed values, and also the
            source if the value comes from the table.
    """
    merged: dict[str, Any] = json.loads(_to_json(table, f"{source}: "))
    valid = dotted_keys()
    for key, value in (overrides or {}).items():
        if key not in valid:
            raise ConfigurationError(f"unknown key {key!r}; {_suggest(key, valid)}")
        *path, leaf = key.split(".")
        place = merged
        for part in path:
            place = place.setdefault(part, {})
            if not isinstance(place, dict):
                raise ConfigurationError(f"{source}: {part!r} must be a table")
        place[leaf] = json.loads(_to_json(value, f"{key} "))
    try:
        return Scenario.model_validate_json(json.dumps(merged), strict=True)
    except ValidationError as error:
        problems = error.errors()
        # An error in the overrides alone does not name the file.
        prefix = "" if {_key(problem) for problem in problems} <= set(overrides or ()) else f"{source}: "
        raise ConfigurationError(prefix + "; ".join(_sentence(problem, valid) for problem in problems)) from error


def load_scenario(name: str | Path, overrides: Mapping[str, Any] | None = None) -> Scenario:
    """Read a shipped scenario by its name, or a TOML file.

    Paths of gains and objects in the file are relative to its folder; paths in `overrides` are relative to the working
    directory.

    Raises:
        ConfigurationError: No shipped scenario has this name, or the file is missing, is not TOML, or does not
            validate.
    """
    path = find(name)
    table = read_toml(path)
    table.setdefault("name", path.stem)
    controller, pile = table.get("controller"), table.get("pile")
    if isinstance(controller, dict) and isinstance(gains := controller.get("gains"), str):
        controller["gains"] = str(path.parent / gains)
    if isinstance(pile, dict) and isinstance(objects := pile.get("object"), str):
        pile["object"] = "+".join(str(path.parent / part) if is_file(part) else part for part in objects.split("+"))
    return build_scenario(table, overrides, source=str(path))


def _read(path: Path) -> bytes:
    """Return the content of a file that a scenario names."""
    try:
        return path.read_bytes()
    except FileNotFoundError:
        raise ConfigurationError(f"{path}: no such file") from None
    except OSError as error:
        raise ConfigurationError(f"{path}: cannot be read: {error.strerror}") from None


def _to_json(value: Any, source: str) -> str:
    """Return a value as JSON; `source` begins the error of a value that JSON cannot hold."""
    try:
        return json.dumps(value, default=_plain)
    except (TypeError, ValueError, RecursionError) as error:
        raise ConfigurationError(f"{source}holds a value that is not a number, text, list or table: {error}") from None


def _plain(value: Any) -> Any:
    """Return a path and numpy's numbers and arrays as JSON values."""
    if isinstance(value, Path):
        return str(value)
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"{value} ({type(value).__name__})")


def _suggest(key: str, valid: list[str]) -> str:
    """Return the remedy for an unknown key: the nearest valid keys, or all of its section."""
    if inside := [name for name in valid if name.startswith(f"{key}.")]:
        return f"it is a table of {', '.join(inside)}"
    section, _, leaf = key.rpartition(".")
    if section:
        siblings = {name.removeprefix(f"{section}."): name for name in valid if name.startswith(f"{section}.")}
        close = [siblings[name] for name in get_close_matches(leaf, siblings, n=1)]
    else:
        siblings = {name.partition(".")[0]: name for name in valid}
        close = [name for name in valid if name.endswith(f".{leaf}")] or get_close_matches(leaf, siblings, n=1)
    close = close if siblings else get_close_matches(key, valid, n=1)
    if close:
        return f"did you mean {' or '.join(map(repr, close))}?"
    return f"valid keys are {', '.join(siblings.values() if section and siblings else valid)}"


def _key(problem: Any) -> str:
    """Return the dotted key of a problem; an entry of a list belongs to the list's key."""
    return problem.get("ctx", {}).get("key") or ".".join(part for part in problem["loc"] if isinstance(part, str))


def _sentence(problem: Any, valid: list[str]) -> str:
    """Return the error text of one of pydantic's problems."""
    key, fault, message = _key(problem), problem["type"], str(problem["msg"])
    if fault == "extra_forbidden":
        return f"unknown key {key!r}; {_suggest(key, valid)}"
    if fault == "idle":
        return message
    if fault in ("tuple_type", "missing", "too_long"):
        entries = "3 numbers, such as [0.5, 0.0, 0.2]" if key.startswith("line.") else "texts"
        return f"{key} = {problem['input']!r:.80} is not allowed: it must be a list of {entries}"
    place = key + "".join(f"[{part}]" for part in problem["loc"] if isinstance(part, int))
    return f"{place} = {problem['input']!r:.80} is not allowed: {_allowed(fault, message)}"


def _allowed(fault: str, message: str) -> str:
    """Return the allowed values in the words of a scenario instead of pydantic's."""
    if fault == "string_pattern_mismatch":
        return "it must not hold control characters"
    if fault == "string_too_short":
        return "it must not be empty"
    for theirs, ours in _WORDS:
        message = message.replace(theirs, ours)
    return message


_WORDS = (
    ("Input should be", "it must be"),
    ("a valid integer", "an integer"),
    ("a valid number", "a number"),
    ("a valid string", "a text"),
    ("an object", "a table"),
    ("less than or equal to", "at most"),
    ("greater than or equal to", "at least"),
)
