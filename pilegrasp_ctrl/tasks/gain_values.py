"""What a user may write as a gain: numbers, and one sentence where something else stands there."""

from __future__ import annotations

from math import inf, isfinite
from typing import Any

import numpy as np

from ..exceptions import ConfigurationError, PilegraspError
from ..types import Array


def six(value: Any, name: str, *, positive: bool = False) -> Array:
    """Return (6,) read-only gains from one number for all axes or six, linear axes first.

    Raises:
        ConfigurationError: where it is something else, or a number is negative or not finite (or zero, if `positive`).
    """
    array = _array(value, name, ((), (6,)), "one number or six, linear axes first")
    array = np.array(np.broadcast_to(array, (6,)))
    if not np.isfinite(array).all() or (array < 0.0).any() or (positive and not (array > 0.0).all()):
        raise ConfigurationError(f"{name} = {array.tolist()} must be {_sign(positive)} and finite")
    array.setflags(write=False)
    return array


def wrench(value: Any, name: str) -> Array:
    """Return (6,) a read-only force and torque.

    Raises:
        ConfigurationError: where it is not six finite numbers.
    """
    array = _array(value, name, ((6,),), "six numbers, force first")
    if not np.isfinite(array).all():
        raise ConfigurationError(f"{name} = {array.tolist()} must be finite")
    array.setflags(write=False)
    return array


def pair(value: Any, name: str) -> tuple[float, float]:
    """Return a force [N] and a torque [N·m] that are not negative.

    Raises:
        ConfigurationError: where it is something else.
    """
    array = _array(value, name, ((2,),), "two numbers, [N] and [N·m]")
    if not np.isfinite(array).all() or (array < 0.0).any():
        raise ConfigurationError(f"{name} = {array.tolist()} must be not negative and finite")
    return float(array[0]), float(array[1])


def scalar(value: Any, name: str, meaning: str, *, positive: bool = False) -> float:
    """Return one number; `meaning` ends the sentence that refuses another value.

    Raises:
        ConfigurationError: where it is negative or not finite (or zero, if `positive`), or no number.
    """
    good = isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)
    if not good or not 0.0 <= value < inf or (positive and value == 0.0):
        number = "positive number" if positive else "finite number that is not negative"
        raise ConfigurationError(f"{name} = {value!r:.80} must be a {number}; {meaning}")
    return float(value)


def checked_wrench(value: Any, name: str, error: type[PilegraspError] = ConfigurationError) -> Array:
    """Return (6,) a force and torque that came in during control; cheap, and as strict as it must be.

    Raises:
        PilegraspError: of the given type, where it is not six finite numbers.
    """
    array: Array = np.asarray(value, dtype=np.float64)
    if array.shape != (6,) or not isfinite(array.dot(array)):
        raise error(f"{name} must be six finite numbers, force first; it is {array.tolist()}")
    return array


def _sign(positive: bool) -> str:
    return "positive" if positive else "not negative"


def _array(value: Any, name: str, shapes: tuple[tuple[int, ...], ...], wanted: str) -> Array:
    try:
        array = np.asarray(value)
    except ValueError:
        array = np.array(None)
    # A truth value among numbers would become 1.0 without a word.
    if array.dtype.kind not in "iuf" or array.shape not in shapes or _holds_truth_value(value):
        shape = f"has the shape {array.shape}; " if array.dtype.kind in "iuf" and array.shape not in shapes else ""
        raise ConfigurationError(f"{name} = {value!r:.80} {shape}{'it ' if shape else ''}must be {wanted}")
    return np.array(array, dtype=np.float64)


def _holds_truth_value(value: Any) -> bool:
    return isinstance(value, list | tuple) and any(isinstance(entry, bool | np.bool_) for entry in value)
