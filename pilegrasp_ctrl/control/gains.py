"""Two kinds of gains, in two types that cannot be confused."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..exceptions import ConfigurationError
from ..types import Array


def _six(value: ArrayLike, name: str, *, positive: bool = False) -> Array:
    array = np.asarray(value, dtype=np.float64)
    if array.shape not in ((), (6,)):
        raise ConfigurationError(f"{name} has shape {array.shape}; one number or six, linear axes first, are expected")
    array = np.array(np.broadcast_to(array, (6,)))
    if not np.isfinite(array).all() or (array < 0.0).any() or (positive and not (array > 0.0).all()):
        allowed = "positive" if positive else "not negative"
        raise ConfigurationError(f"{name} = {array.tolist()} must be {allowed} and finite")
    array.setflags(write=False)
    return array


def _ratio(value: float) -> float:
    if not isinstance(value, int | float) or not 0.0 < value < np.inf:
        raise ConfigurationError(f"damping_ratio = {value!r} must be a positive number; 1 is critical damping")
    return float(value)


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
        object.__setattr__(self, "stiffness", _six(stiffness, "stiffness", positive=True))
        object.__setattr__(self, "damping_ratio", _ratio(damping_ratio))

    @property
    def damping(self) -> Array:
        """(6,) velocity gains [1/s]."""
        return 2.0 * self.damping_ratio * np.sqrt(self.stiffness)


@dataclass(frozen=True, slots=True, eq=False, init=False)
class Impedance:
    """How the hand yields: springs and dampers between the reference and the tool, world axes, linear axes first.

    Attributes:
        stiffness: a scalar or (6,) [N/m, N·m/rad]; zero leaves an axis to its desired force.
        damping_ratio: of the springs, on the inertia that the tool shows; 1 is critical damping.
        damping: (6,) viscous damping beside that of the springs [N·s/m, N·m·s/rad].
        inertia: (6,) inertia that the tool shall show [kg, kg·m²], shaped with the measured wrench; None keeps the
            arm's own, which needs no sensor.
        desired_force: (6,) what the hand shall exert on the environment [N, N·m].
        dead_band: (2,) force [N] and torque [N·m] below which the measured wrench is taken as zero; it matters only
            where `inertia` is given.

    Raises:
        ConfigurationError: where a value is negative or not finite, or an axis has neither stiffness nor damping.
    """

    stiffness: Array
    damping_ratio: float = 1.0
    damping: Array = field(default_factory=lambda: np.zeros(6))
    inertia: Array | None = None
    desired_force: Array = field(default_factory=lambda: np.zeros(6))
    dead_band: tuple[float, float] = (0.0, 0.0)

    def __init__(
        self,
        stiffness: ArrayLike,
        damping_ratio: float = 1.0,
        damping: ArrayLike = 0.0,
        inertia: ArrayLike | None = None,
        desired_force: ArrayLike = (0.0,) * 6,
        dead_band: ArrayLike = (0.0, 0.0),
    ) -> None:
        stiffness, damping = _six(stiffness, "stiffness"), _six(damping, "damping")
        if not (stiffness + damping > 0.0).all():
            raise ConfigurationError("an axis has neither stiffness nor damping, so its speed would grow without bound")
        object.__setattr__(self, "stiffness", stiffness)
        object.__setattr__(self, "damping_ratio", _ratio(damping_ratio))
        object.__setattr__(self, "damping", damping)
        object.__setattr__(self, "inertia", None if inertia is None else _six(inertia, "inertia", positive=True))
        force = np.array(desired_force, dtype=np.float64)
        if force.shape != (6,) or not np.isfinite(force).all():
            raise ConfigurationError(f"desired_force = {force.tolist()} must be six finite numbers, force first")
        force.setflags(write=False)
        object.__setattr__(self, "desired_force", force)
        band = np.asarray(dead_band, dtype=np.float64)
        if band.shape != (2,) or not np.isfinite(band).all() or (band < 0.0).any():
            raise ConfigurationError(f"dead_band = {band.tolist()} must be two numbers, [N] and [N·m], not negative")
        object.__setattr__(self, "dead_band", (float(band[0]), float(band[1])))


_KINDS: dict[str, type[MotionGains] | type[Impedance]] = {"motion": MotionGains, "impedance": Impedance}


def load_gains(path: str | Path) -> MotionGains | Impedance:
    """Read gains from a TOML file with one table, `[motion]` or `[impedance]`, whose keys are the type's attributes.

    Raises:
        ConfigurationError: where the file is missing, is not TOML, or holds a key or value that cannot be used.
    """
    path = Path(path)
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise ConfigurationError(f"{path}: no such file of gains") from None
    except OSError as error:
        raise ConfigurationError(f"{path}: cannot be read: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ConfigurationError(f"{path}: is not valid TOML: {error}") from None
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
    except (TypeError, ValueError) as error:
        raise ConfigurationError(f"{source}: a value is not a number or a list of numbers: {error}") from None
