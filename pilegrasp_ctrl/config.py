"""Scenarios: read from a TOML file and `--set key=value`, checked key by key, and hashed."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from pydantic import Field, ValidationError, field_validator, model_validator
from pydantic_core import PydanticCustomError

from . import hand_folder as hands
from .exceptions import ConfigurationError
from .files import MAX_TOML_SIZE, read_file, read_toml
from .hand_description import abilities_of, idle_changes
from .neutral_values import NEUTRAL_VALUES
from .plugins import is_plugin, plugin_digest
from .problems import LISTS, allowed_values
from .program_traits import (
    OPERATORS,
    PLAN_PARAMETERS,
    PROGRAM_TRAITS,
    RULE_PARAMETERS,
    ProgramTraits,
    is_operator,
    is_program,
    traits_of,
)
from .robots import folder_digest, is_folder
from .scenarios import find, is_file, object_digests, object_parts
from .sections import (
    ControllerConfig,
    HandModelConfig,
    KnownConfig,
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
from .settings import check_text, parse_value, to_json

MAX_PROBLEMS = 20
"""Largest number of wrong keys that an error names; chosen."""


class Scenario(Section):
    """Complete description of an attempt; together with a seed it fixes the result."""

    name: Name = Field(default="unnamed", description="name; that of the file if absent")
    summary: Text = Field(default="", description="one line for `pilegrasp list`")
    tags: tuple[Text, ...] = Field(default=(), description="tags for `pilegrasp list --tag`")
    program: Name = Field(
        default="grasp",
        description="grasp, push, line, order or swap, or your own plan as module:function, see --plugins",
    )
    robot: Name = Field(default="wam7", description="arm: one that ships, or the folder of your own, with a slash")
    hand: Name = Field(default="rbo_hand2", description="hand: its name, or the path of the folder of your own")
    hand_model: HandModelConfig = HandModelConfig()
    support: SupportConfig = SupportConfig()
    known: KnownConfig = KnownConfig()
    pile: PileConfig = PileConfig()
    strategy: StrategyConfig = StrategyConfig()
    line: LineConfig = LineConfig()
    order: OrderConfig = OrderConfig()
    controller: ControllerConfig = ControllerConfig()
    sensor: SensorConfig = SensorConfig()
    sim: SimulationConfig = SimulationConfig()

    @field_validator("program")
    @classmethod
    def _a_program_is_known(cls, name: str) -> str:
        """Reject a program that neither ships nor is written as a user's plan."""
        if not is_program(name):
            raise PydanticCustomError(
                "idle",
                "program = {name} is not allowed: it must be {known}, or your own plan as module:function",
                {"key": "program", "name": f"{name!r:.80}", "known": ", ".join(map(repr, PROGRAM_TRAITS))},
            )
        return name

    @property
    def traits(self) -> ProgramTraits:
        """Traits of the program."""
        return traits_of(self.program)

    @model_validator(mode="after")
    def _the_hand_is_known(self) -> Scenario:
        """Reject a name that no shipped hand has. The folder of a hand is looked for when it is used."""
        for key, hand in (("hand", self.hand), ("strategy.pushing_hand", self.strategy.pushing_hand)):
            if hand is None or hands.is_path(hand) or hand in hands.names():
                continue
            allowed = f"it must be {', '.join(map(repr, hands.names()))}, or the folder of a hand, such as './{hand}'"
            context = {"key": key, "hand": repr(hand)[:80], "allowed": allowed}
            raise PydanticCustomError("idle", "{key} = {hand} is not allowed: {allowed}", context)
        if self.traits.swaps != (self.strategy.pushing_hand is not None):
            raise PydanticCustomError(
                "idle",
                "program = 'swap' and strategy.pushing_hand, such as 'plate', belong together; give both or none",
                {"key": "strategy.pushing_hand"},
            )
        return self

    @model_validator(mode="after")
    def _every_key_counts(self) -> Scenario:
        """Reject a value that the program or the hand does not read."""
        idle = {"strategy", "line", "order"} - self.traits.sections
        for section in sorted(idle):
            for key in getattr(self, section).changed():
                if NEUTRAL_VALUES.get((section, key)) == getattr(getattr(self, section), key):
                    continue
                raise PydanticCustomError(
                    "idle",
                    "{key} has no effect if program = '{program}'; leave it out",
                    {"key": f"{section}.{key}", "program": self.program},
                )
        if not self.traits.touches and self.support.slope_error_deg != 0.0:
            raise PydanticCustomError(
                "idle",
                "{key} has no effect if program = '{program}', which touches no floor; leave it out",
                {"key": "support.slope_error_deg", "program": self.program},
            )
        for key in self.known.changed():
            without = {"support": self.support.kind == "none", "pile": self.pile.count == 0}
            if not self.traits.touches or without.get(key.partition("_")[0], False):
                raise PydanticCustomError(
                    "idle",
                    "{key} has no effect without {what}; leave it out",
                    {"key": f"known.{key}", "what": f"a {key.partition('_')[0]} that the hand works at"},
                )
        if self.pile.frame_position is not None and not self.support.bin:
            raise PydanticCustomError(
                "idle",
                "{key} has no effect without a bin; leave it out, or make support.bin = true",
                {"key": "pile.frame_position"},
            )
        if self.controller.keep_clear and not self.support.bin:
            raise PydanticCustomError(
                "idle",
                "{key} has no effect without a bin; leave it out, or make support.bin = true",
                {"key": "controller.keep_clear"},
            )
        for key in idle_changes(hands.parameters(self.hand), self.hand_model) if self.hand_model.changed() else ():
            raise PydanticCustomError(
                "idle",
                "{key} has no effect if hand = '{hand}', which has no such number or does not close; leave it out",
                {"key": f"hand_model.{key}", "hand": self.hand},
            )
        return self

    @model_validator(mode="after")
    def _the_operator_is_known(self) -> Scenario:
        """Reject an operator that neither ships nor is written as a user's rule."""
        if not is_operator(self.order.operator):
            raise PydanticCustomError(
                "idle",
                "order.operator = {name} is not allowed: it must be {known}, or your own rule as module:function",
                {
                    "key": "order.operator",
                    "name": f"{self.order.operator!r:.80}",
                    "known": ", ".join(map(repr, OPERATORS)),
                },
            )
        return self

    @model_validator(mode="after")
    def _an_order_comes_from_a_bin(self) -> Scenario:
        """Reject an order without a bin, objects, or a hand that can release them."""
        if not self.traits.delivers:
            return self
        releases = "release" in abilities_of(hands.parameters(self.hand))
        if not (self.support.bin and releases and self.pile.count):
            wanted = "support.bin = true, a hand that can release objects, and pile.count of 1 or more"
            raise PydanticCustomError(
                "idle",
                "program = '{program}' needs {wanted}",
                {"key": "program", "program": self.program, "wanted": wanted},
            )
        return self

    def config_hash(self) -> str:
        """Return 16 hex digits that are equal for scenarios with the same physics and control.

        Name, summary and tags do not count. Files of gains and objects, a user's plan and arm count by their content.

        Raises:
            ConfigurationError: One of these files cannot be read.
        """
        content = self.model_dump(mode="json", exclude={"name", "summary", "tags"})
        for (section, key), value in NEUTRAL_VALUES.items():
            if content[section][key] == value:
                del content[section][key]
        if not content["known"]:
            del content["known"]
        if not self.traits.delivers:
            content["order"].pop("operator", None)
        if is_plugin(self.program):
            digest = plugin_digest(self.program, "program", PLAN_PARAMETERS, named=True)
            content["program"] = [self.program.partition(":")[2], digest]
        if is_plugin(operator := self.order.operator):
            digest = plugin_digest(operator, "order.operator", RULE_PARAMETERS, named=True)
            content["order"]["operator"] = [operator.partition(":")[2], digest]
        content |= {"robot": folder_digest(self.robot)} if is_folder(self.robot) else {}
        if self.controller.gains is not None:
            gains = read_file(Path(self.controller.gains), MAX_TOML_SIZE, "of gains")
            content["controller"]["gains"] = hashlib.sha256(gains).hexdigest()
        if hands.is_path(self.hand):
            content["hand"] = hands.digests(self.hand)
        if (pushing := self.strategy.pushing_hand) and hands.is_path(pushing):
            content["strategy"]["pushing_hand"] = hands.digests(pushing)
        if is_file(self.pile.object):
            parts = object_parts(self.pile.object)
            content["pile"]["object"] = [object_digests(Path(part)) if is_file(part) else part for part in parts]
            if self.pile.frame_size is None and any(is_file(part) for part in parts):
                content["pile"]["frame_size"] = "by the size of the parts"
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
    """Read `key=value` texts; a value that is not valid TOML is taken as a string. The last text of a key counts.

    Raises:
        ConfigurationError: A text has no `=` or no key, or a part of a value would be ignored.
    """
    overrides: dict[str, Any] = {}
    for text in texts:
        key, separator, value = (part.strip() for part in text.partition("="))
        if not separator or not key:
            raise ConfigurationError(f"--set {text!r:.80} is not of the form key=value, for example --set pile.count=5")
        try:
            overrides[key] = parse_value(value)
        except ConfigurationError as error:
            raise ConfigurationError(f"--set {text!r:.80}: {error}") from None
    return overrides


def build_scenario(
    table: Mapping[str, Any], overrides: Mapping[str, Any] | None = None, source: str = "scenario"
) -> Scenario:
    """Validate a nested table and dotted overrides.

    Raises:
        ConfigurationError: A key or value cannot be used. The error names it and the allowed values, and also the
            source if the value comes from the table.
    """
    merged: dict[str, Any] = json.loads(to_json(table, f"{source}: "))
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
        place[leaf] = json.loads(to_json(value, f"{key} "))
    check_text(merged, source)
    try:
        return Scenario.model_validate_json(json.dumps(merged), strict=True)
    except ValidationError as error:
        problems = error.errors()
        # An error in the overrides alone does not name the file.
        prefix = "" if {_key(problem) for problem in problems} <= set(overrides or ()) else f"{source}: "
        sentences = [_sentence(problem, valid) for problem in problems[:MAX_PROBLEMS]]
        more = [f"and {len(problems) - MAX_PROBLEMS} more"] if len(problems) > MAX_PROBLEMS else []
        raise ConfigurationError(prefix + "; ".join([*sentences, *more])) from error


def load_scenario(name: str | Path, overrides: Mapping[str, Any] | None = None) -> Scenario:
    """Read a shipped scenario by its name, or a TOML file.

    Paths of gains, robot, hand and objects in the file are relative to its folder; paths in `overrides` to the
    working directory.

    Raises:
        ConfigurationError: No shipped scenario has this name, or the file is missing, is not TOML, or does not
            validate.
    """
    path = find(name)
    table = read_toml(path)
    table.setdefault("name", path.stem)
    for key in ("robot", "hand"):
        if isinstance(folder := table.get(key), str) and hands.is_path(folder):
            table[key] = hands.beside(path.parent, folder)
    controller, pile = table.get("controller"), table.get("pile")
    if isinstance(controller, dict) and isinstance(gains := controller.get("gains"), str):
        controller["gains"] = str(path.parent / gains)
    if isinstance(pile, dict) and isinstance(objects := pile.get("object"), str):
        pile["object"] = "+".join(str(path.parent / part) if is_file(part) else part for part in objects.split("+"))
    return build_scenario(table, overrides, source=str(path))


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
    if fault == "json_invalid":
        return "the tables are nested too deeply"
    if fault in ("tuple_type", "missing", "too_long"):
        value = problem["input"]
        return f"{key} = {value!r:.80} is not allowed: it must be a list of {LISTS.get(key, 'texts')}"
    place = key + "".join(f"[{part}]" for part in problem["loc"] if isinstance(part, int))
    return f"{place} = {problem['input']!r:.80} is not allowed: {allowed_values(fault, message)}"
