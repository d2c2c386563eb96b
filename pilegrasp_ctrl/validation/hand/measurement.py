"""One measured number of a hand, beside what it should be and what others have published."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from ...statistics import markdown_table

Check = tuple[str, float, float, float, str, str]
"""Name, requested, measured, tolerance, unit and relation."""


@dataclass(frozen=True, slots=True)
class Measurement:
    """A number with its unit.

    Attributes:
        name: what was measured.
        value: what came out, in `unit`.
        unit: of `value`, `requested` and `tolerance`.
        requested: what it should be, by a formula, a setting or a publication.
        tolerance: how far off it may be.
        relation: whether a deviation counts on both sides, or only above or below what was requested.
        published: a figure for the real hand with its source, or "" where none was found.
    """

    name: str
    value: float
    unit: str
    requested: float
    tolerance: float
    relation: Literal["=", "<=", ">="]
    published: str = ""

    @property
    def ok(self) -> bool:
        """Whether the value is within tolerance; one that is not finite never is."""
        excess = self.value - self.requested
        excess = abs(excess) if self.relation == "=" else -excess if self.relation == ">=" else excess
        return math.isfinite(self.value) and excess <= self.tolerance

    def check(self) -> Check:
        """Return the plain numbers of the check."""
        return self.name, self.requested, self.value, self.tolerance, self.unit, self.relation

    def cells(self) -> tuple[str, ...]:
        """Return the row as it is printed."""
        sign = {"=": "", "<=": "≤ ", ">=": "≥ "}[self.relation]
        margin = f" ± {self.tolerance:.3g}" if self.relation == "=" else ""
        return (
            self.name,
            f"{self.value:.3g} {self.unit}",
            f"{sign}{self.requested:.3g}{margin}",
            self.published or "none found",
        )


def markdown(measurements: tuple[Measurement, ...]) -> str:
    """Return the measurements as a Markdown table."""
    return markdown_table(("", "measured", "should be", "published"), (row.cells() for row in measurements))
