"""The space of a search: the keys that it varies, and the values that each may take."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..config import Scenario, load_scenario
from ..exceptions import ConfigurationError
from ..settings import parse_value, parse_values
from . import MAX_CHOICES, MAX_PARAMETERS

STEPS = 200
"""Number of steps into which a range is divided [-]; chosen, so that values are short to read."""


@dataclass(frozen=True, slots=True)
class Range:
    """Numbers from `low` to `high`, both included.

    Attributes:
        key: Dotted key.
        low: Smallest value.
        high: Largest value.
        whole: Whether only whole numbers are values.
    """

    key: str
    low: float
    high: float
    whole: bool = False

    @property
    def size(self) -> float:
        """Number of values."""
        return self.high - self.low + 1 if self.whole else math.inf

    def value(self, share: float) -> float | int:
        """Return the nearest value of a grid of `STEPS` steps."""
        if self.whole:
            return int(self.low) + min(int(share * self.size), int(self.size) - 1)
        digits = 1 - math.floor(math.log10((self.high - self.low) / STEPS))
        near = round(self.low + round(share * STEPS) / STEPS * (self.high - self.low), digits)
        return float(min(max(near, self.low), self.high))

    def share(self, value: Any) -> float | None:
        """Return the share of a number in the range; None for any other value."""
        if isinstance(value, bool) or not isinstance(value, int | float) or not self.low <= value <= self.high:
            return None
        return (value - self.low + 0.5) / self.size if self.whole else (value - self.low) / (self.high - self.low)

    def distance(self, one: Any, other: Any) -> float:
        """Return the distance of two numbers as a share of the range; 1 where one of them is no number."""
        if not all(isinstance(value, int | float) for value in (one, other)):
            return 0.0 if one == other else 1.0
        return abs(float(one) - float(other)) / (self.high - self.low)


@dataclass(frozen=True, slots=True)
class Choice:
    """Values without an order, such as names of hands.

    Attributes:
        key: Dotted key.
        values: Values, at least two.
    """

    key: str
    values: tuple[Any, ...]

    @property
    def size(self) -> float:
        """Number of values."""
        return len(self.values)

    def value(self, share: float) -> Any:
        """Return the value at a share."""
        return self.values[min(int(share * len(self.values)), len(self.values) - 1)]

    def share(self, value: Any) -> float | None:
        """Return the middle of a value's part; None for a value that is not in the list."""
        return (self.values.index(value) + 0.5) / len(self.values) if value in self.values else None

    def distance(self, one: Any, other: Any) -> float:
        """Return 0 for equal values, and 1 otherwise."""
        return 0.0 if one == other else 1.0


Parameter = Range | Choice
"""A key of a scenario that a search varies."""


def parse_over(texts: Iterable[str]) -> list[Parameter]:
    """Read `key=low:high` and `key=a,b,c` texts.

    Raises:
        ConfigurationError: A text has another form, a key comes twice, a range is empty, reversed or not finite, or
            there are too many keys or values.
    """
    found: dict[str, Parameter] = {}
    for text in texts:
        shown = f"--over {text!r:.80}"
        key, separator, values = (part.strip() for part in text.partition("="))
        if not separator or not key or not values:
            raise ConfigurationError(
                f"{shown} is not of the form key=low:high or key=a,b,c, as in --over strategy.speed=0.05:0.4"
            )
        if key in found:
            raise ConfigurationError(f"--over {key:.80} is given twice; put all its values behind one")
        found[key] = _range(key, values, shown) or _choice(key, values, shown)
    if not found:
        raise ConfigurationError("--over is missing; name at least one key, as in --over strategy.speed=0.05:0.4")
    if len(found) > MAX_PARAMETERS:
        raise ConfigurationError(f"--over names {len(found)} keys; {MAX_PARAMETERS} are allowed")
    return list(found.values())


def _range(key: str, text: str, shown: str) -> Range | None:
    """Return a range, or None if the text is no pair of numbers."""
    parts = text.split(":")
    if len(parts) != 2:
        return None
    ends = [parse_value(part.strip()) for part in parts]
    if any(isinstance(end, bool) or not isinstance(end, int | float) for end in ends):
        return None
    if any(isinstance(end, int) and abs(end) > 1e15 for end in ends) or not all(map(math.isfinite, ends)):
        raise ConfigurationError(f"{shown}: the ends of a range must be finite numbers, as in 0.05:0.4")
    low, high = ends
    if not low < high:
        raise ConfigurationError(f"{shown}: the range must go from a smaller to a larger number, as in 0.05:0.4")
    return Range(key, low, high)


def _choice(key: str, text: str, shown: str) -> Choice:
    try:
        values = parse_values(text)
    except ConfigurationError as error:
        raise ConfigurationError(f"{shown}: {error}") from None
    if len(values) < 2:
        raise ConfigurationError(f"{shown}: give a range, as in 0.05:0.4, or at least two values, as in a,b")
    if len(values) > MAX_CHOICES:
        raise ConfigurationError(f"{shown}: has {len(values)} values; {MAX_CHOICES} are allowed")
    if any(value in values[:place] for place, value in enumerate(values)):
        raise ConfigurationError(f"{shown}: a value is given twice; leave out one of the two")
    return Choice(key, tuple(values))


@dataclass(frozen=True, slots=True)
class Space:
    """The values that candidates may have.

    Attributes:
        parameters: Keys with their values.
        start: The scenario's own value of each key.
    """

    parameters: tuple[Parameter, ...]
    start: Mapping[str, Any]

    @classmethod
    def around(cls, scenario: str | Path, parameters: Iterable[Parameter], overrides: Mapping[str, Any]) -> Space:
        """Return the space around a scenario, with every end and every value checked.

        Raises:
            ConfigurationError: A key is unknown, is also set, has no effect, or does not allow a value.
        """
        start = load_scenario(scenario, overrides)
        checked: list[Parameter] = []
        own: dict[str, Any] = {}
        for parameter in parameters:
            if parameter.key in overrides:
                raise ConfigurationError(f"{parameter.key} is set and searched over; leave out one of the two")
            ends = list(parameter.values) if isinstance(parameter, Choice) else [parameter.low, parameter.high]
            found = [load_scenario(scenario, {**overrides, parameter.key: value}) for value in ends]
            if len({each.config_hash() for each in found}) < len(found):
                raise ConfigurationError(f"--over {parameter.key}: two of its values mean the same; leave out one")
            whole = isinstance(parameter, Range) and isinstance(value_at(found[0], parameter.key), int)
            checked.append(replace(parameter, whole=whole) if isinstance(parameter, Range) else parameter)
            own[parameter.key] = value_at(start, parameter.key)
        return cls(tuple(checked), own)

    @property
    def size(self) -> float:
        """Number of combinations; infinite with a range of real numbers."""
        return math.prod(parameter.size for parameter in self.parameters)

    def values(self, shares: Mapping[str, float]) -> dict[str, Any]:
        """Return the values at shares in [0, 1]."""
        return {parameter.key: parameter.value(shares[parameter.key]) for parameter in self.parameters}

    def distance(self, values: Mapping[str, Any]) -> float:
        """Return the distance of values from the start: the sum over the keys, each as a share of its range."""
        return math.fsum(
            parameter.distance(values[parameter.key], self.start[parameter.key]) for parameter in self.parameters
        )


def value_at(scenario: Scenario, key: str) -> Any:
    """Return the value of a dotted key as plain JSON."""
    value: Any = scenario.model_dump(mode="json")
    for part in key.split("."):
        value = value[part]
    return value
