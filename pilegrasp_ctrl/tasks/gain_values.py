"""Checks of the numbers that a user gives as gains, and of wrenches that come in during control."""

from __future__ import annotations

from math import inf, isfinite
from typing import Any

import numpy as np

from ..exceptions import ConfigurationError, PilegraspError
from ..kernels.algebra import length_square
from ..types import Array


def read_axes(value: Any, name: str, *, positive: bool = False) -> Array:
    """Return (6,) read-only gains from one number for all axes or six, linear axes first.

    Raises:
        ConfigurationError: The value has another form, or a number is negative or not finite (or zero, if `positive`).
    """
    array = _read_array(value, name, ((), (6,)), "one number or six, linear axes first")
    array = np.array(np.broadcast_to(array, (6,)))
    if not np.isfinite(array).all() or (array < 0.0).any() or (positive and not (array > 0.0).all()):
        raise ConfigurationError(
            f"{name} = {array.tolist()} must be finite and {'positive' if positive else 'not negative'}"
        )
    array.setflags(write=False)
    return array


def read_wrench(value: Any, name: str) -> Array:
    """Return (6,) a read-only force and torque.

    Raises:
        ConfigurationError: The value is not six finite numbers.
    """
    array = _read_array(value, name, ((6,),), "six numbers, force first")
    if not np.isfinite(array).all():
        raise ConfigurationError(f"{name} = {array.tolist()} must be finite")
    array.setflags(write=False)
    return array


def read_pair(value: Any, name: str) -> tuple[float, float]:
    """Return a force [N] and a torque [N·m] that are not negative.

    Raises:
        ConfigurationError: The value is not two finite numbers, or one of them is negative.
    """
    array = _read_array(value, name, ((2,),), "two numbers, [N] and [N·m]")
    if not np.isfinite(array).all() or (array < 0.0).any():
        raise ConfigurationError(f"{name} = {array.tolist()} must be finite and not negative")
    return float(array[0]), float(array[1])


def read_number(value: Any, name: str, meaning: str, *, positive: bool = False) -> float:
    """Return one number; `meaning` is the end of the error text.

    Raises:
        ConfigurationError: The value is not a number, is negative or is not finite (or is zero, if `positive`).
    """
    good = isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)
    if not good or not 0.0 <= value < inf or (positive and value == 0.0):
        number = "positive number" if positive else "finite number that is not negative"
        raise ConfigurationError(f"{name} = {value!r:.80} must be a {number}; {meaning}")
    return float(value)


def check_wrench(value: Any, name: str, error: type[PilegraspError] = ConfigurationError) -> Array:
    """Return (6,) a force and torque that came in during control, after a cheap check.

    Raises:
        PilegraspError: The value is not six finite numbers; the error has the given type.
    """
    try:
        array: Array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise error(f"{name} must be six finite numbers, force first; it is {value!r:.80}") from None
    if array.shape != (6,) or not isfinite(length_square(array)):
        raise error(f"{name} must be six finite numbers, force first; it is {array.tolist()}")
    return array


def _read_array(value: Any, name: str, shapes: tuple[tuple[int, ...], ...], wanted: str) -> Array:
    try:
        array = np.asarray(value)
    except ValueError:
        array = np.array(None)
    # numpy would silently turn a boolean among numbers into 1.0.
    if array.dtype.kind not in "iuf" or array.shape not in shapes or _holds_boolean(value):
        shape = f"has the shape {array.shape}; " if array.dtype.kind in "iuf" and array.shape not in shapes else ""
        raise ConfigurationError(f"{name} = {value!r:.80} {shape}{'it ' if shape else ''}must be {wanted}")
    return np.array(array, dtype=np.float64)


def _holds_boolean(value: Any) -> bool:
    return isinstance(value, list | tuple) and any(isinstance(entry, bool | np.bool_) for entry in value)
