"""Which of the finished trials are worth looking at, and which one is proposed."""

from __future__ import annotations

from collections.abc import Sequence

from .objectives import Measured
from .store import TrialRecord
from .trial import REQUIRED_MARGIN

RULE = (
    f"of the trials that do not ring at {REQUIRED_MARGIN:g} times their stiffness, the one with the smallest product "
    "of tracking², activity and, where a force ends the push, the largest force"
)
"""A product has no scales to be chosen: a tenth off one factor is worth as much as a tenth off another, and the
smallest one always lies on the Pareto front. Tracking counts twice, because it is what the gains are for."""
NO_MARGIN = (
    f"no trial was free of ringing at {REQUIRED_MARGIN:g} times its stiffness, so that the one that rings least stands "
    "here; do not use it"
)


def merit(measured: Measured, grasp_force: float) -> float:
    """Return the logarithm of what `RULE` makes small.

    Args:
        measured: of a trial.
        grasp_force: F_grasp [N].
    """
    tracking, *others = measured.scores(grasp_force)
    return 2.0 * tracking + sum(others)


def choose(records: Sequence[TrialRecord], grasp_force: float) -> tuple[TrialRecord | None, str]:
    """Return the trial that is proposed and the rule that it was chosen by; None where none was completed.

    Args:
        records: the finished trials.
        grasp_force: F_grasp [N].
    """
    feasible = [record for record in records if record.report.feasible]
    if feasible:
        return min(feasible, key=lambda record: _merit(record, grasp_force)), RULE
    completed = [record for record in records if record.report.measured is not None]
    if completed:
        return min(completed, key=lambda record: (max(record.report.ringing), _merit(record, grasp_force))), NO_MARGIN
    return None, ""


def pareto_front(records: Sequence[TrialRecord]) -> list[TrialRecord]:
    """Return the trials with margin of which no other is better in one objective and worse in none, by tracking."""
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
    assert record.report.measured is not None
    return merit(record.report.measured, grasp_force)
