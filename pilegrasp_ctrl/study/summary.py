"""What a study found, condition by condition."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from ..statistics import wilson
from .attempt import AttemptRow
from .condition import Condition
from .store import StudyStore


@dataclass(frozen=True, slots=True)
class SummaryRow:
    """The attempts of one condition, counted.

    Attributes:
        condition: the scenario's name under "scenario", and what was varied.
        n: attempts, those that raised among them.
        successes: attempts that did what they were for.
        rate: successes / n.
        ci_low: lower end of the 95 % interval of the rate.
        ci_high: upper end.
        multiple: attempts that held more than one object.
        triggered: attempts whose push ended because the wrist sensor felt F_grasp.
        errors: attempts that raised; they count as not successful.
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

    def as_dict(self) -> dict[str, Any]:
        """Return plain JSON values."""
        return asdict(self)


def summarise(
    store: StudyStore | Iterable[AttemptRow], tasks: list[tuple[Condition, int]] | None = None
) -> list[SummaryRow]:
    """Return a row for each condition.

    Args:
        store: a study, or attempts of one.
        tasks: the conditions and seeds to count, in this order; all of the study where absent.

    Raises:
        ExportError: where the store cannot be read.
    """
    rows = store.attempts(tasks) if isinstance(store, StudyStore) else store
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
    )
