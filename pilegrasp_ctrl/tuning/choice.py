"""The choice among finished trials: the Pareto front, and the trial that is proposed."""

from __future__ import annotations

import math
from collections.abc import Sequence

from .objectives import Measured
from .store import TrialRecord
from .trial import REQUIRED_MARGIN

RULE = (
    f"of the trials that do not ring at {REQUIRED_MARGIN:g} times their stiffness, the one with the smallest product "
    "of tracking², activity and, where a force ends the push, the largest force"
)
"""Rule of the choice. A product needs no scales: 10 % less of one factor counts as much as 10 % less of another. The
smallest product always lies on the Pareto front. Tracking counts twice, because it is the purpose of the gains."""
NO_MARGIN = (
    f"every trial rings at {REQUIRED_MARGIN:g} times its stiffness; the trial that rings least is shown; do not use it"
)
"""Sentence in place of the rule if no trial keeps its margin."""


def merit(measured: Measured, grasp_force: float) -> float:
    """Return the logarithm of the product that `RULE` minimises.

    Args:
        measured: Measurements of a trial.
        grasp_force: Force threshold F_grasp [N].
    """
    tracking, *others = measured.scores(grasp_force)
    return 2.0 * tracking + sum(others)


def choose(records: Sequence[TrialRecord], grasp_force: float) -> tuple[TrialRecord | None, str]:
    """Return the proposed trial and the rule of the choice; (None, "") if no trial was completed.

    Args:
        records: Finished trials.
        grasp_force: Force threshold F_grasp [N].
    """
    feasible = [record for record in records if record.report.feasible]
    if feasible:
        return min(feasible, key=lambda record: _merit(record, grasp_force)), RULE
    completed = [record for record in records if record.report.measured is not None]
    if completed:
        return min(completed, key=lambda record: (max(record.report.ringing), _merit(record, grasp_force))), NO_MARGIN
    return None, ""


def pareto_front(records: Sequence[TrialRecord]) -> list[TrialRecord]:
    """Return the trials with margin that no other trial dominates, sorted by tracking error."""
    rows = [
        (record, record.report.measured.objectives())
        for record in records
        if record.report.feasible and record.report.measured is not None
    ]

    def dominated(own: tuple[float, ...]) -> bool:
        return any(other != own and all(a <= b for a, b in zip(other, own, strict=True)) for _, other in rows)

    front = [(record, own) for record, own in rows if not dominated(own)]
    return [record for record, _ in sorted(front, key=lambda row: row[1])]


def _merit(record: TrialRecord, grasp_force: float) -> float:
    measured = record.report.measured
    return math.inf if measured is None else merit(measured, grasp_force)
