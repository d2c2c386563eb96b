"""Checks as lines of a table."""

from __future__ import annotations

from collections.abc import Sequence

from ...statistics import markdown_table
from .physics_check import PhysicsCheck

HEADER = ("check", "requested", "measured", "tolerance", "verdict")


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
