"""Keys of an object's file, checked one by one; every refusal names the key and what is allowed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from difflib import get_close_matches
from typing import Any

from ..exceptions import ConfigurationError


def subtable(keys: Mapping[str, Any], key: str, valid: tuple[str, ...] | None) -> dict[str, Any]:
    """Return the table `key` of `keys`, empty where it is absent.

    Raises:
        ConfigurationError: where it is no table, or holds a key that is not among `valid`, if that is given.
    """
    table = keys.get(key, {})
    if not isinstance(table, Mapping):
        raise ConfigurationError(f"{key} = {table!r:.80} must be a table")
    if valid is not None:
        refuse_unknown(table, valid, f"[{key}]")
    return dict(table)


def refuse_unknown(keys: Mapping[str, Any], valid: tuple[str, ...], what: str) -> None:
    """Refuse a key that is not valid; `what` says of what.

    Raises:
        ConfigurationError: names the key and the nearest valid one, or all.
    """
    for key in keys:
        if key not in valid:
            close = get_close_matches(key, valid, n=1)
            remedy = f"did you mean {close[0]!r}?" if close else f"valid keys are {', '.join(valid)}"
            raise ConfigurationError(f"{what} has no key {key!r}; {remedy}")


def number(keys: Mapping[str, Any], key: str, bounds: tuple[float, float], unit: str, prefix: str = "") -> float:
    """Return the number `key`, which must lie within `bounds`; `prefix` is that of the table it stands in.

    Raises:
        ConfigurationError: where it is missing, no number, or outside.
    """
    if key not in keys:
        raise ConfigurationError(f"the key {prefix + key!r} is missing")
    return _within(keys[key], prefix + key, bounds, unit)


def numbers(keys: Mapping[str, Any], key: str, bounds: tuple[float, float]) -> list[float]:
    """Return the three lengths [m] of the list `key`, each within `bounds`.

    Raises:
        ConfigurationError: where it is missing, no such list, or a length is outside.
    """
    values = keys.get(key)
    if not isinstance(values, list | tuple) or len(values) != 3:
        raise ConfigurationError(f"{key} = {values!r:.80} must be a list of 3 lengths in m")
    return [_within(value, f"{key}[{i}]", bounds, "m") for i, value in enumerate(values)]


def _within(value: Any, key: str, bounds: tuple[float, float], unit: str) -> float:
    low, high = bounds
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if not number or not math.isfinite(value) or not low <= value <= high:
        allowed = f"{low:g} to {high:g} {unit}".rstrip()
        raise ConfigurationError(f"{key} = {value!r:.80} must be a number from {allowed}")
    return float(value)
