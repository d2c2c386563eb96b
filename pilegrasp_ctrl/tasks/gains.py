"""Gains of motion and of impedance, in two types that cannot be confused."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..exceptions import ConfigurationError
from ..files import read_toml
from ..types import Array
from .gain_values import read_axes, read_number, read_pair, read_wrench

FRAMES = ("world", "tool")
"""Frames whose axes an impedance can use."""
FORCE_GAIN_MEANING = "it is a rate in 1/s, and 0 turns the feedback off"
"""End of the error text for a force gain."""
_CRITICAL = "1 is critical damping"
"""End of the error text for a damping ratio."""


@dataclass(frozen=True, slots=True, eq=False, init=False)
class MotionGains:
    """Operational-space gains: the rate at which the tool's error decays, whatever the arm's inertia.

    The commanded tool acceleration is `a_ref + damping (v_ref - v) + stiffness e` with
    `damping = 2 damping_ratio sqrt(stiffness)` [1/s].

    Attributes:
        stiffness: Scalar or (6,) stiffness, linear axes first, world axes [1/s²].
        damping_ratio: Damping ratio; 1 is critical damping.

    Raises:
        ConfigurationError: A value is not positive and finite.
    """

    stiffness: Array
    damping_ratio: float = 1.0

    def __init__(self, stiffness: ArrayLike, damping_ratio: float = 1.0) -> None:
        object.__setattr__(self, "stiffness", read_axes(stiffness, "stiffness", positive=True))
        object.__setattr__(self, "damping_ratio", read_number(damping_ratio, "damping_ratio", _CRITICAL, positive=True))

    @property
    def damping(self) -> Array:
        """(6,) Velocity gains [1/s]."""
        return 2.0 * self.damping_ratio * np.sqrt(self.stiffness)


@dataclass(frozen=True, slots=True, eq=False, init=False)
class Impedance:
    """Gains of springs and dampers between the reference and the tool, linear axes first.

    All values are along the axes of `frame`. `docs/impedance.md` has the law and a table of every gain.

    Attributes:
        stiffness: Scalar or (6,) stiffness [N/m, N·m/rad]; zero leaves an axis to its desired force.
        damping_ratio: Damping ratio of the springs on the inertia that the tool shows; 1 is critical damping, 0 leaves
            all damping to `damping`.
        damping: (6,) Viscous damping in addition to that of the springs [N·s/m, N·m·s/rad].
        inertia: (6,) Inertia that the tool should show [kg, kg·m²], shaped with the measured wrench; None keeps the
            inertia of the arm, which needs no sensor.
        desired_force: (6,) Wrench that the hand should exert on the environment [N, N·m].
        dead_band: (2,) Force [N] and torque [N·m] below which the measured wrench counts as zero; used only with
            `inertia`.
        frame: "world", or "tool" for the axes of the tool frame in the reference's orientation.
        force_gain: Rate at which the measured force corrects the desired one [1/s]; zero relies on the model.

    Raises:
        ConfigurationError: A value is negative or not finite, an axis has neither stiffness nor damping, or a spring
            has no damper.
    """

    stiffness: Array
    damping_ratio: float = 1.0
    damping: Array = field(default_factory=lambda: np.zeros(6))
    inertia: Array | None = None
    desired_force: Array = field(default_factory=lambda: np.zeros(6))
    dead_band: tuple[float, float] = (0.0, 0.0)
    frame: str = "world"
    force_gain: float = 0.0

    def __init__(
        self,
        stiffness: ArrayLike,
        damping_ratio: float = 1.0,
        damping: ArrayLike = 0.0,
        inertia: ArrayLike | None = None,
        desired_force: ArrayLike = (0.0,) * 6,
        dead_band: ArrayLike = (0.0, 0.0),
        frame: str = "world",
        force_gain: float = 0.0,
    ) -> None:
        values = {
            "stiffness": read_axes(stiffness, "stiffness"),
            "damping_ratio": read_number(damping_ratio, "damping_ratio", _CRITICAL),
            "damping": read_axes(damping, "damping"),
            "inertia": None if inertia is None else read_axes(inertia, "inertia", positive=True),
            "desired_force": read_wrench(desired_force, "desired_force"),
            "dead_band": read_pair(dead_band, "dead_band"),
            "frame": frame,
            "force_gain": read_number(force_gain, "force_gain", FORCE_GAIN_MEANING),
        }
        if not (isinstance(frame, str) and frame in FRAMES):
            raise ConfigurationError(f"frame = {frame!r:.80} must be one of {', '.join(map(repr, FRAMES))}")
        for name, value in values.items():
            object.__setattr__(self, name, value)
        if not (self.stiffness + self.damping > 0.0).all():
            raise ConfigurationError(
                "an axis has neither stiffness nor damping, so its speed would grow without bound; give it one"
            )
        if self.damping_ratio == 0.0 and not (self.damping > 0.0).all():
            raise ConfigurationError(
                "damping_ratio = 0 needs damping on every axis, or a spring would oscillate forever"
            )


_TABLES: dict[str, type[MotionGains] | type[Impedance]] = {"motion": MotionGains, "impedance": Impedance}
"""Table of a gains file -> type of its gains."""


def load_gains(path: str | Path) -> MotionGains | Impedance:
    """Read gains from a TOML file with one table, `[motion]` or `[impedance]`, whose keys are the type's attributes.

    Raises:
        ConfigurationError: The file is missing, is not TOML, or has a key or value that cannot be used.
    """
    path = Path(path)
    table = read_toml(path, "of gains")
    if len(table) != 1 or not set(table) <= set(_TABLES) or not isinstance(next(iter(table.values())), dict):
        raise ConfigurationError(
            f"{path}: one table is expected, [motion] in 1/s² or [impedance] in N/m and N·m/rad; found {list(table)}"
        )
    name, values = next(iter(table.items()))
    return _build(_TABLES[name], values, f"{path}: [{name}]")


def _build(cls: type[MotionGains] | type[Impedance], values: dict[str, Any], source: str) -> MotionGains | Impedance:
    valid = [attribute.name for attribute in fields(cls)]
    if unknown := [key for key in values if key not in valid]:
        raise ConfigurationError(f"{source}: unknown key {unknown[0]!r}; valid keys are {', '.join(valid)}")
    if "stiffness" not in values:
        raise ConfigurationError(f"{source}: the key 'stiffness' is missing")
    try:
        return cls(**values)
    except ConfigurationError as error:
        raise ConfigurationError(f"{source}: {error}") from None
