"""The gains that a search may try: bounds with a physical reason, and the text of a file of gains."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, Self

import numpy as np

from ..exceptions import ConfigurationError
from ..tasks.gains import Impedance, MotionGains

Gains = MotionGains | Impedance
"""Gains of an operational-space or of an impedance controller."""

AXES = {"translation": slice(0, 3), "rotation": slice(3, 6)}
"""Axes of the stiffness that each number of a search scales."""

MIN_FREQUENCY = 5.0
"""Smallest natural frequency that is tried [rad/s] (chosen): an error takes a second to decay."""
MAX_PHASE = 0.2
"""Largest natural frequency times the control period [rad] (chosen): ten ticks for 63 % of a critically damped step."""
IMPEDANCE_BOUNDS = {"translation": (100.0, 10000.0), "rotation": (5.0, 500.0)}
"""Bounds of an impedance [N/m, N·m/rad]. The softest spring yields 10 mm under 1 N; the stiffest presses with 200 N,
the largest F_grasp, at 20 mm. The rotation has the same springs on a lever of about 0.2 m, from hand to fingertips."""
DAMPING_BOUNDS = (0.3, 2.0)
"""Bounds of the damping ratio (chosen): from an overshoot of 37 % to a decay four times slower than critical."""


@dataclass(frozen=True, slots=True, eq=False)
class GainSpace:
    """The three numbers of a search: `translation` and `rotation`, the largest stiffness of their axes, and a ratio.

    Everything else stays as in the start gains: the proportions of the axes, and for an impedance its explicit damping,
    inertia, desired force and dead band. A number that is zero at the start stays zero, such as the damping ratio of an
    impedance that is damped explicitly.

    Attributes:
        start: Gains at which the search begins.
        bounds: Lowest and highest value of "translation", "rotation" [1/s², or N/m and N·m/rad] and "damping_ratio".
    """

    start: Gains
    bounds: Mapping[str, tuple[float, float]]

    @classmethod
    def around(cls, start: Gains, rate: float) -> Self:
        """Return the space around start gains; a start outside the usual bounds moves them.

        Args:
            start: Gains at which the search begins.
            rate: Control rate [Hz]; it limits the stiffness of a motion, not that of an impedance.

        Raises:
            ConfigurationError: The start has no stiffness at all.
        """
        motion = (MIN_FREQUENCY**2, (MAX_PHASE * rate) ** 2)
        usual = dict.fromkeys(AXES, motion) if isinstance(start, MotionGains) else IMPEDANCE_BOUNDS
        values = _values(start)
        if not values.keys() & AXES.keys():
            raise ConfigurationError("the start gains have no stiffness, so there is nothing to search over")
        wanted = {**usual, "damping_ratio": DAMPING_BOUNDS}
        bounds = {name: (min(wanted[name][0], value), max(wanted[name][1], value)) for name, value in values.items()}
        return cls(start, bounds)

    @property
    def start_values(self) -> dict[str, float]:
        """Numbers of the start gains."""
        return _values(self.start)

    @property
    def units(self) -> dict[str, str]:
        """Unit of each number."""
        motion = isinstance(self.start, MotionGains)
        known = {"translation": "1/s²" if motion else "N/m", "rotation": "1/s²" if motion else "N·m/rad"}
        return {name: known.get(name, "1") for name in self.bounds}

    def rounded(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return the values rounded to three digits; those of the start stay exact."""
        if dict(values) == self.start_values:
            return dict(values)
        return {name: float(f"{value:.3g}") for name, value in values.items()}

    def gains(self, values: Mapping[str, float]) -> Gains:
        """Return the start gains with these numbers."""
        stiffness = np.array(self.start.stiffness)
        for name, value in values.items():
            # Unchanged numbers keep their bits, so that the start equals the file that was given.
            if name in AXES and value != self.start_values[name]:
                part = stiffness[AXES[name]]
                part[:] = part / part.max() * value
        return replace(self.start, stiffness=stiffness, damping_ratio=values.get("damping_ratio", 0.0))


def scaled(gains: Gains, factor: float) -> Gains:
    """Return the gains with `factor` times the stiffness and the same damping ratio."""
    return replace(gains, stiffness=gains.stiffness * factor)


def gains_text(gains: Gains, comment: str = "") -> str:
    """Return the content of a file that `load_gains` reads back to the same bits.

    Args:
        gains: Gains to write.
        comment: Lines for the head of the file.
    """
    motion = isinstance(gains, MotionGains)
    lines = [f"# {line}" for line in comment.splitlines()]
    lines.append(f"[{'motion' if motion else 'impedance'}]")
    unit = "   # 1/s²" if motion else "   # N/m, N·m/rad"
    usual = _table(type(gains)(1.0))
    for name, value in _table(gains).items():
        if name in ("stiffness", "damping_ratio") or value != usual[name]:
            lines.append(f"{name} = {value!r}{unit if name == 'stiffness' else ''}")
    return "\n".join(lines) + "\n"


def gains_table(gains: Gains) -> dict[str, Any]:
    """Return the gains as JSON values below the name of their table."""
    return {"motion" if isinstance(gains, MotionGains) else "impedance": _table(gains)}


def _values(gains: Gains) -> dict[str, float]:
    found = {name: float(np.max(gains.stiffness[axes])) for name, axes in AXES.items()}
    found["damping_ratio"] = gains.damping_ratio
    return {name: value for name, value in found.items() if value > 0.0}


def _table(gains: Gains) -> dict[str, Any]:
    return {attribute.name: _plain(getattr(gains, attribute.name)) for attribute in fields(gains)}


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.tolist()
    return list(value) if isinstance(value, tuple) else value
