"""The result of a study: attempts counted by condition."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from statistics import fmean
from typing import Any

from ..statistics import wilson
from .attempt import AttemptRow
from .condition import Attempt
from .store import StudyStore


@dataclass(frozen=True, slots=True)
class SummaryRow:
    """The counts of one condition.

    Attributes:
        condition: Scenario's name under "scenario", and the varied values.
        n: Number of attempts, including those that raised.
        successes: Number of successful attempts.
        rate: Success rate, successes / n.
        ci_low: Lower end of the 95 % Wilson interval of the rate.
        ci_high: Upper end of the interval.
        multiple: Number of attempts that held more than one object.
        triggered: Number of attempts whose push ended because the wrist sensor felt F_grasp.
        errors: Number of attempts that raised; they count as not successful.
        measures: Mean of each number of the measure, over the attempts that have it; empty without a measure.
    """

    condition: Mapping[str, Any]
    n: int
    successes: int
    rate: float
    ci_low: float
    ci_high: float
    multiple: int
    triggered: int
    errors: int
    measures: Mapping[str, float] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """Return plain JSON values; `measures` only if there are any."""
        document = asdict(self)
        return document if self.measures else {key: value for key, value in document.items() if key != "measures"}


def summarise(store: StudyStore | Iterable[AttemptRow], attempts: Sequence[Attempt] | None = None) -> list[SummaryRow]:
    """Return a row for each condition.

    Args:
        store: Study, or rows of one.
        attempts: Conditions and seeds to count, in this order; the whole study if absent.

    Raises:
        ExportError: The store cannot be read.
    """
    rows = store.attempts(attempts) if isinstance(store, StudyStore) else store
    groups: dict[str, list[AttemptRow]] = {}
    for row in rows:
        groups.setdefault(row.config_hash, []).append(row)
    return [_summary(group) for group in groups.values()]


def _summary(rows: list[AttemptRow]) -> SummaryRow:
    n, successes = len(rows), sum(row.success for row in rows)
    ci_low, ci_high = wilson(successes, n)
    return SummaryRow(
        condition=rows[0].condition,
        n=n,
        successes=successes,
        rate=successes / n,
        ci_low=ci_low,
        ci_high=ci_high,
        multiple=sum(row.grasped > 1 for row in rows),
        triggered=sum(row.triggered for row in rows),
        errors=sum(row.error is not None for row in rows),
        measures=_means(rows),
    )


def _means(rows: list[AttemptRow]) -> dict[str, float]:
    """Return the mean of each number of the measures; what is no number is left out."""
    found: dict[str, list[float]] = {}
    for row in rows:
        for name, value in ((row.result or {}).get("measures") or {}).items():
            if isinstance(value, int | float):
                found.setdefault(name, []).append(float(value))
    return {name: fmean(values) for name, values in found.items()}
