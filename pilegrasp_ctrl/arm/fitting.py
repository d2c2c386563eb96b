"""Checks that the parts of a controller fit its arm and its rate."""

from __future__ import annotations

from math import isfinite
from typing import Any

from ..exceptions import ArgumentError, ConfigurationError, ModelError
from ..types import Observation
from .model import ArmModel


def check_arm(arm: object, part: str) -> None:
    """Refuse what is not an arm.

    Raises:
        ArgumentError: `arm` is not an `ArmModel`; `part` names the class that takes it.
    """
    if not isinstance(arm, ArmModel):
        raise ArgumentError(f"{part} takes the arm first, an ArmModel, not {type(arm).__name__}")


def check_same_arm(part: object, arm: ArmModel) -> None:
    """Refuse a task, a limit or a feed-forward whose attribute `arm`, if it has one, has other joints.

    Raises:
        ConfigurationError: The joints differ.
    """
    own = getattr(part, "arm", arm)
    if own.joint_names != arm.joint_names:
        raise ConfigurationError(f"{part!r:.80} was made for {own.name}, its controller for {arm.name}; use one arm")


def check_rate(rate: Any) -> float:
    """Return a control rate [Hz].

    Raises:
        ConfigurationError: It is not a positive, finite number.
    """
    if isinstance(rate, bool) or not isinstance(rate, int | float) or not (isfinite(rate) and rate > 0.0):
        raise ConfigurationError(f"rate = {rate!r:.80} must be a positive frequency [Hz]")
    return float(rate)


def check_observation(observation: Any) -> None:
    """Refuse what is not an observation; the arm checks its joint positions and velocities.

    Raises:
        ModelError: It has another type, or its time is not a finite number.
    """
    if not isinstance(observation, Observation):
        raise ModelError(f"an observation is an Observation(time, q, v), not {type(observation).__name__}")
    if not isinstance(observation.time, int | float) or not isfinite(observation.time):
        raise ModelError(f"the time of the observation must be a finite number [s]; it is {observation.time!r:.80}")
