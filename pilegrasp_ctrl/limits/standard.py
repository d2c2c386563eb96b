"""The limits that every arm has, by their names."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from ..arm.fitting import check_same_arm
from ..arm.model import ArmModel
from ..exceptions import ConfigurationError
from .limit import Limit
from .motion_limits import PositionLimit, VelocityLimit
from .torque_limit import TorqueLimit

LIMITS = ("torque", "velocity", "position")
"""Names of the limits that every arm has, in arguments and in `active_limits`."""


def limits_of(arm: ArmModel, rate: float = 500.0) -> list[Limit]:
    """Return the limits of torque, velocity and position of an arm under control at `rate` [Hz].

    Raises:
        ConfigurationError: The rate is not positive and finite, or a joint cannot brake.
    """
    return [_made(name, arm, rate) for name in LIMITS]


def read_limits(arm: ArmModel, limits: Collection[str | Limit] | None, rate: float) -> list[Limit]:
    """Return a controller's limits from names and objects; None stands for all that the arm has.

    Raises:
        ConfigurationError: A name is unknown, or an object is no limit.
    """
    if limits is None:
        return limits_of(arm, rate)
    if isinstance(limits, str | Mapping) or not isinstance(limits, Collection):
        raise ConfigurationError(f"limits = {limits!r:.80} must be a list, such as ['torque', 'velocity', 'position']")
    return [_made(limit, arm, rate) if isinstance(limit, str) else check_limit(limit, arm, rate) for limit in limits]


def _made(name: str, arm: ArmModel, rate: float) -> Limit:
    """Return the limit of a name.

    Raises:
        ConfigurationError: The name is unknown, or a joint cannot brake.
    """
    if name == "torque":
        return TorqueLimit(arm)
    if name == "velocity":
        return VelocityLimit(arm, rate)
    if name == "position":
        return PositionLimit(arm, rate)
    raise ConfigurationError(f"no limit {name!r}; the limits are {', '.join(LIMITS)}, and any Limit object")


def check_limit(limit: Any, arm: ArmModel, rate: float) -> Limit:
    """Return an object that is a limit of an arm for control at `rate` [Hz].

    Raises:
        ConfigurationError: It is no limit, or was made for another arm or rate.
    """
    if isinstance(limit, type) or not (callable(getattr(limit, "rows", None)) and hasattr(limit, "hard")):
        raise ConfigurationError(
            f"{limit!r:.80} is no limit; a limit has the attribute hard and the method rows(state) -> Bounds"
        )
    check_same_arm(limit, arm)
    own = getattr(limit, "rate", rate)
    if own != rate:
        raise ConfigurationError(
            f"{limit!r:.80} was made for {own:g} Hz, the controller for {rate:g} Hz; make both alike"
        )
    found: Limit = limit
    return found
