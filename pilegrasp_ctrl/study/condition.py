"""Conditions of a study: scenarios, and the values in which they differ."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Any

from ..config import Scenario, load_scenario
from ..exceptions import ConfigurationError
from ..scenarios import is_file
from . import MAX_CONDITIONS


@dataclass(frozen=True)
class Condition:
    """One combination of a study; together with a seed it is an attempt.

    Attributes:
        scenario: Complete scenario.
        varied: Values in which the conditions of the study differ, by dotted key or by any other name.
    """

    scenario: Scenario
    varied: Mapping[str, Any]

    @cached_property
    def config_hash(self) -> str:
        """Scenario's hash, computed at the first use."""
        return self.scenario.config_hash()

    @cached_property
    def placed(self) -> Scenario:
        """Scenario with absolute paths of its files, so that it means the same in any working directory."""
        controller, pile = self.scenario.controller, self.scenario.pile
        if controller.gains is not None:
            controller = controller.model_copy(update={"gains": str(Path(controller.gains).absolute())})
        if is_file(pile.object):
            pile = pile.model_copy(update={"object": str(Path(pile.object).absolute())})
        return self.scenario.model_copy(update={"controller": controller, "pile": pile})

    def as_dict(self) -> dict[str, Any]:
        """Return plain JSON values: the scenario's name and the varied values."""
        return {"scenario": self.scenario.name, **self.varied}


Attempt = tuple[Condition, int]
"""A condition and a seed."""


def conditions(
    scenario: str | Path, vary: Mapping[str, Sequence[Any]], overrides: Mapping[str, Any] | None = None
) -> list[Condition]:
    """Return every combination of the values of `vary` on top of a scenario; the last key varies fastest.

    Args:
        scenario: Name of a scenario that ships, or a TOML file.
        vary: Values by dotted key.
        overrides: Dotted keys and values that all combinations share.

    Raises:
        ConfigurationError: A combination is not a valid scenario, a key has no values or is also in `overrides`, there
            are too many combinations, or two of them are the same configuration. One sentence names everything that is
            wrong.
    """
    shared = dict(overrides or {})
    for key, values in vary.items():
        if not values:
            raise ConfigurationError(f"{key} is varied but has no values; give at least one, as in {key}=1,2")
        if key in shared:
            raise ConfigurationError(f"{key} is set and varied; leave out one of the two")
    count = math.prod(len(values) for values in vary.values())
    if count > MAX_CONDITIONS:
        raise ConfigurationError(
            f"{', '.join(vary)} have {count:.3g} combinations; {MAX_CONDITIONS} are allowed, so leave out some values"
        )
    found: list[Condition] = []
    # The same sentence comes from every combination that holds the value; a dictionary keeps each once, in order.
    wrong: dict[str, None] = {}
    for values in product(*vary.values()):
        varied = dict(zip(vary, values, strict=True))
        try:
            found.append(Condition(load_scenario(scenario, {**shared, **varied}), varied))
        except ConfigurationError as error:
            wrong[str(error)] = None
    if wrong:
        raise ConfigurationError("; ".join(wrong))
    known: dict[str, Condition] = {}
    for condition in found:
        other = known.setdefault(condition.config_hash, condition)
        if other is not condition:
            raise ConfigurationError(
                f"{_text(other)} and {_text(condition)} are the same configuration; leave out one of them"
            )
    return found


def _text(condition: Condition) -> str:
    return ", ".join(f"{key} = {value}" for key, value in condition.varied.items())
