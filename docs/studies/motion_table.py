"""The motion pattern of a condition: many attempts in one field and one row of numbers, for motion_pattern.py."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pilegrasp_ctrl.analysis.motion import measure
from pilegrasp_ctrl.analysis.motion_field import MotionField
from pilegrasp_ctrl.analysis.push_motion import PushMotion
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.scenarios.paper.motion_verdict import measured
from pilegrasp_ctrl.statistics import markdown_table

SPEEDS = ("approach_speed", "spread_speed", "spread_forward", "spread_sideways", "funnel_width")
"""Measures that have a mean and a standard deviation."""


@dataclass(frozen=True, slots=True, eq=False)
class MotionPattern:
    """The motion pattern of the attempts at one condition.

    Attributes:
        name: Name of the condition.
        measures: Measures of each attempt.
        field: Sum of the attempts' fields; None if no pile was pushed.
        example: First attempt with a pushed pile, whose hand and walls are drawn.
    """

    name: str
    measures: tuple[dict[str, Any], ...]
    field: MotionField | None
    example: Recording | None

    @classmethod
    def of(cls, name: str, recordings: Iterable[Recording]) -> MotionPattern:
        """Measure attempts, one after the other; only one recording is kept."""
        measures, field, example = [], None, None
        for recording in recordings:
            measures.append(measure(recording))
            push = PushMotion.of(recording)
            if push is not None:
                own = MotionField.of(push)
                field = own if field is None else field + own
                example = example or recording
        return cls(name, tuple(measures), field, example)

    def summary(self) -> dict[str, Any]:
        """Return the condition as one JSON row."""
        return {"condition": self.name} | summary(self.measures)


def summary(measures: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return counts, and means with standard deviations over attempts, of the measures of one condition.

    Keys are `attempts`, `triggered`, `separated`, `stabilised`, `held` and `agreed` (numbers of attempts), and for each
    name in `SPEEDS` a dictionary of `mean`, `std` and `n`. If contacts were recorded, `chain_objects` and
    `chain_to_support` have the same form.
    """
    chains = [row["force_chains"] for row in measures if "force_chains" in row]
    separated = [row["separated"] for row in measures if row["separated"]]
    return {
        "attempts": len(measures),
        "triggered": sum(row["triggered"] for row in measures),
        "separated": len(separated),
        "stabilised": sum(row["stabilised"] is not None for row in separated),
        "held": sum(bool(row["held"]) for row in measures),
        "agreed": sum(bool(row["agreed"]) for row in measures),
    } | {
        **{name: _spread(measured(measures, name)) for name in SPEEDS},
        **{f"chain_{name}": _spread(measured(chains, name)) for name in ("objects", "to_support") if chains},
    }


def markdown(patterns: Sequence[MotionPattern]) -> str:
    """Return a Markdown table with a column for each condition: mean ± standard deviation, in mm/s or mm."""
    rows = [pattern.summary() for pattern in patterns]
    lines = []
    for name in ("attempts", "triggered", "separated", "stabilised", "held", "agreed"):
        lines.append([name, *(str(row[name]) for row in rows)])
    for name in SPEEDS:
        unit = "mm" if name.endswith("width") else "mm/s"
        lines.append([f"{name.replace('_', ' ')} [{unit}]", *(_cell(row[name], 1e3, 0) for row in rows)])
    if all("chain_objects" in row for row in rows):
        lines.append(["objects in force chains", *(_cell(row["chain_objects"], 1.0, 1) for row in rows)])
        lines.append(["chains at a wall [% of the time]", *(_cell(row["chain_to_support"], 1e2, 0) for row in rows)])
    return markdown_table(("", *(row["condition"] for row in rows)), lines)


def _spread(numbers: list[float]) -> dict[str, Any]:
    n = len(numbers)
    return {
        "mean": float(np.mean(numbers)) if n else None,
        "std": float(np.std(numbers, ddof=1)) if n > 1 else None,
        "n": n,
    }


def _cell(entry: Mapping[str, Any], factor: float, digits: int) -> str:
    if entry["mean"] is None:
        return "none"
    deviation = "" if entry["std"] is None else f" ± {factor * entry['std']:.{digits}f}"
    return f"{factor * entry['mean']:.{digits}f}{deviation}"
