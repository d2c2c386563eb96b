"""One line of `pilegrasp doctor --physics`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal


@dataclass(frozen=True, slots=True)
class PhysicsCheck:
    """What was asked of the physics, and what was measured.

    Attributes:
        name: what was measured, where.
        requested: the number that is asked for, in `unit`.
        measured: the number that the engine gave, in `unit`.
        tolerance: how far off it may be, in `unit`.
        unit: of the three numbers; "-" for a ratio.
        relation: whether a deviation counts on both sides, or only above or below what was requested.
        known: why it is known to be missed, where it is; such a miss is told and does not fail the whole.
    """

    name: str
    requested: float
    measured: float
    tolerance: float
    unit: str
    relation: Literal["=", "<=", ">="] = "="
    known: str = ""

    @property
    def ok(self) -> bool:
        """Whether the measurement is within tolerance; one that is not finite never is."""
        excess = self.measured - self.requested
        if self.relation == "=":
            excess = abs(excess)
        elif self.relation == ">=":
            excess = -excess
        return bool(math.isfinite(self.measured) and excess <= self.tolerance)

    def as_dict(self) -> dict[str, Any]:
        """Return plain JSON values; a measurement that is not finite becomes None."""
        return {
            "name": self.name,
            "requested": self.requested,
            "measured": self.measured if math.isfinite(self.measured) else None,
            "tolerance": self.tolerance,
            "unit": self.unit,
            "relation": self.relation,
            "ok": self.ok,
            "known": self.known,
        }
