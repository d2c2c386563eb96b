"""Two kinds of gains, in two types that cannot be confused."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..exceptions import ConfigurationError
from ..files import read_toml
from ..types import Array
from .gain_values import pair, scalar, six, wrench

FRAMES = ("world", "tool")

_CRITICAL = "1 is critical damping"


@dataclass(frozen=True, slots=True, eq=False, init=False)
class MotionGains:
    """Operational-space gains: how fast the tool's error decays, whatever the arm's inertia.

    The commanded tool acceleration is `a_ref + damping (v_ref - v) + stiffness e` with
    `damping = 2 damping_ratio sqrt(stiffness)` [1/s].

    Attributes:
        stiffness: a scalar or (6,), linear axes first, world axes [1/s²].
        damping_ratio: 1 is critical damping.

    Raises:
        ConfigurationError: where a value is not positive and finite.
    """

    stiffness: Array
    damping_ratio: float = 1.0

    def __init__(self, stiffness: ArrayLike, damping_ratio: float = 1.0) -> None:
        object.__setattr__(self, "stiffness", six(stiffness, "stiffness", positive=True))
        object.__setattr__(self, "damping_ratio", scalar(damping_ratio, "damping_ratio", _CRITICAL, positive=True))

    @property
    def damping(self) -> Array:
        """(6,) velocity gains [1/s]."""
        return 2.0 * self.damping_ratio * np.sqrt(self.stiffness)


@dataclass(frozen=True, slots=True, eq=False, init=False)
class Impedance:
    """How the hand yields: springs and dampers between the reference and the tool, linear axes first.

    All values are along the axes of `frame`. `docs/impedance.md` has the law, and a table of every gain.

    Attributes:
        stiffness: a scalar or (6,) [N/m, N·m/rad]; zero leaves an axis to its desired force.
        damping_ratio: of the springs, on the inertia that the tool shows; 1 is critical damping, 0 leaves all to
            `damping`.
        damping: (6,) viscous damping beside that of the springs [N·s/m, N·m·s/rad].
        inertia: (6,) inertia that the tool shall show [kg, kg·m²], shaped with the measured wrench; None keeps the
            arm's own, which needs no sensor.
        desired_force: (6,) what the hand shall exert on the environment [N, N·m].
        dead_band: (2,) force [N] and torque [N·m] below which the measured wrench is taken as zero; it matters only
            where `inertia` is given.
        frame: "world", or "tool" for the axes of the tool frame in the reference's orientation.
        force_gain: how fast the measured force corrects the desired one [1/s]; zero relies on the model.

    Raises:
        ConfigurationError: where a value is negative or not finite, an axis has neither stiffness nor damping, or a
            spring has no damper.
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
            "stiffness": six(stiffness, "stiffness"),
            "damping_ratio": scalar(damping_ratio, "damping_ratio", _CRITICAL),
            "damping": six(damping, "damping"),
            "inertia": None if inertia is None else six(inertia, "inertia", positive=True),
            "desired_force": wrench(desired_force, "desired_force"),
            "dead_band": pair(dead_band, "dead_band"),
            "frame": frame,
            "force_gain": scalar(force_gain, "force_gain", "it is a rate in 1/s, and 0 turns the feedback off"),
        }
        if not (isinstance(frame, str) and frame in FRAMES):
            raise ConfigurationError(f"frame = {frame!r:.80} must be one of {', '.join(map(repr, FRAMES))}")
        for name, value in values.items():
            object.__setattr__(self, name, value)
        if not (self.stiffness + self.damping > 0.0).all():
            raise ConfigurationError("an axis has neither stiffness nor damping, so its speed would grow without bound")
        if self.damping_ratio == 0.0 and not (self.damping > 0.0).all():
            raise ConfigurationError("damping_ratio = 0 needs damping on every axis, or a spring would swing for ever")


_KINDS: dict[str, type[MotionGains] | type[Impedance]] = {"motion": MotionGains, "impedance": Impedance}


def load_gains(path: str | Path) -> MotionGains | Impedance:
    """Read gains from a TOML file with one table, `[motion]` or `[impedance]`, whose keys are the type's attributes.

    Raises:
        ConfigurationError: where the file is missing, is not TOML, or holds a key or value that cannot be used.
    """
    path = Path(path)
    table = read_toml(path, "of gains")
    if len(table) != 1 or not set(table) <= set(_KINDS) or not isinstance(next(iter(table.values())), dict):
        raise ConfigurationError(
            f"{path}: one table is expected, [motion] in 1/s² or [impedance] in N/m and N·m/rad; found {list(table)}"
        )
    kind, values = next(iter(table.items()))
    return _build(_KINDS[kind], values, f"{path}: [{kind}]")


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
