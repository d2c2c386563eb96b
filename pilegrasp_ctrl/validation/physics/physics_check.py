"""One line of `pilegrasp doctor --physics`: a requested and a measured number, their verdict, and the table."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

from ...statistics import markdown_table

Relation = Literal["=", "<=", ">="]
"""Sides of the requested number on which a deviation counts: both, above, or below."""

HEADER = ("check", "requested", "measured", "tolerance", "verdict")
"""Columns of the table."""


@dataclass(frozen=True, slots=True)
class PhysicsCheck:
    """A requested number beside the measured one.

    Attributes:
        name: Quantity and place of the measurement.
        requested: Requested number in `unit`, by a formula, a setting or a publication.
        measured: Measured number in `unit`.
        tolerance: Allowed deviation in `unit`.
        unit: Unit of the three numbers; "-" for a ratio.
        relation: Sides on which a deviation counts.
        known: Reason of a known miss, or ""; a known miss is reported, and the run still passes.
        published: Number for the real hand with its source, or "" if none was found or none applies.
    """

    name: str
    requested: float
    measured: float
    tolerance: float
    unit: str
    relation: Relation = "="
    known: str = ""
    published: str = ""

    @property
    def ok(self) -> bool:
        """Whether the measurement is finite and within tolerance."""
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


def cells(check: PhysicsCheck) -> tuple[str, str, str, str, str]:
    """Return a check as the texts of one line of a table."""
    unit = "" if check.unit == "-" else f" {check.unit}"
    sign = {"=": "±", "<=": "+", ">=": "-"}[check.relation]
    verdict = "ok" if check.ok else f"missed: {check.known}" if check.known else "failed"
    numbers = (f"{check.requested:.4g}{unit}", f"{check.measured:.3g}{unit}", f"{sign}{check.tolerance:.2g}{unit}")
    return check.name, *numbers, verdict


def markdown(checks: Sequence[PhysicsCheck]) -> str:
    """Return the checks as a Markdown table."""
    return markdown_table(HEADER, map(cells, checks))
