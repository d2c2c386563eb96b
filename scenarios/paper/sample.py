"""Attempts that belong together, counted."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from pilegrasp_ctrl.statistics import wilson
from pilegrasp_ctrl.study.attempt import AttemptRow


@dataclass(frozen=True, slots=True)
class Sample:
    """The attempts of one condition, or of several that are judged together.

    Attributes:
        rows: one an attempt. One that raised counts as an attempt without success.
    """

    rows: tuple[AttemptRow, ...]

    @classmethod
    def pooled(cls, samples: Iterable[Sample]) -> Sample:
        """Return the attempts of all samples as one."""
        return cls(tuple(row for sample in samples for row in sample.rows))

    @property
    def n(self) -> int:
        """Number of attempts."""
        return len(self.rows)

    @property
    def successes(self) -> int:
        """Number of attempts that held an object."""
        return sum(row.success for row in self.rows)

    @property
    def multiple(self) -> int:
        """Number of attempts that held more than one object."""
        return sum(row.success and row.grasped > 1 for row in self.rows)

    @property
    def triggered(self) -> int:
        """Number of attempts in which the force along the push reached F_grasp."""
        return sum(row.triggered for row in self.rows)

    @property
    def errors(self) -> int:
        """Number of attempts that raised."""
        return sum(row.error is not None for row in self.rows)

    @property
    def rate(self) -> float:
        """Share of successes; 0 of 0 is 0."""
        return self.successes / self.n if self.rows else 0.0

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % Wilson interval of the rate; all of [0, 1] where nothing was run."""
        return wilson(self.successes, self.n)

    @property
    def mean_grasped(self) -> float:
        """Mean number of objects held, failures counted as 0."""
        return sum(row.grasped for row in self.rows if row.success) / self.n if self.rows else 0.0

    def measures(self, *path: str) -> list[Any]:
        """Return the measure at `path` of every attempt that has it."""
        found = []
        for row in self.rows:
            value: Any = None if row.result is None else row.result.get("measures")
            for key in path:
                value = value.get(key) if isinstance(value, dict) else None
            if value is not None:
                found.append(value)
        return found

    def as_dict(self) -> dict[str, Any]:
        """Return the counts as plain JSON values."""
        low, high = self.interval
        return {
            "n": self.n,
            "successes": self.successes,
            "rate": self.rate if self.rows else None,
            "ci_low": low,
            "ci_high": high,
            "multiple": self.multiple,
            "triggered": self.triggered,
            "errors": self.errors,
        }
