"""The attempts of a store by condition, and their counts."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from pilegrasp_ctrl.statistics import wilson
from pilegrasp_ctrl.study.attempt import AttemptRow
from pilegrasp_ctrl.study.condition import Condition


@dataclass(frozen=True, slots=True)
class Sample:
    """The attempts of one condition, or of several that are judged together.

    Attributes:
        rows: Attempts. One that raised counts as an attempt without success.
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
        """The 95 % Wilson interval of the rate; [0, 1] without attempts."""
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


@dataclass(frozen=True)
class Evidence:
    """The attempts of a store; iterating gives the samples, one for each condition.

    Attributes:
        samples: Attempts by the hash of their configuration.
        hands: End-effectors by the same hash, for single grasps only; orders are left out.
    """

    samples: dict[str, Sample]
    hands: dict[str, str]

    @classmethod
    def from_rows(cls, rows: Iterable[AttemptRow], conditions: Iterable[Condition]) -> Evidence:
        """Return the attempts by their configuration; attempts at other conditions are left out."""
        known = {condition.config_hash: condition.scenario for condition in conditions}
        groups: dict[str, list[AttemptRow]] = {}
        for row in rows:
            if row.config_hash in known:
                groups.setdefault(row.config_hash, []).append(row)
        hands: dict[str, str] = {key: scenario.hand for key, scenario in known.items() if not scenario.support.bin}
        return cls({key: Sample(tuple(group)) for key, group in groups.items()}, hands)

    def sample(self, *conditions: Condition) -> Sample:
        """Return the attempts at one condition, or at several as one sample."""
        return Sample.pooled(self.samples.get(condition.config_hash, Sample(())) for condition in conditions)

    def samples_of(self, conditions: dict[str, Condition]) -> dict[str, Sample]:
        """Return the attempts at each condition, by the same names."""
        return {name: self.sample(condition) for name, condition in conditions.items()}

    def balanced_sample(self, conditions: Iterable[Condition]) -> Sample:
        """Return equally many attempts of several conditions as one sample, the attempts with the lowest seeds.

        Its rate is therefore the mean over the conditions, although another figure may need more attempts at some of
        them. The sample is empty while one condition has no attempts.
        """
        samples = [self.sample(condition) for condition in conditions]
        fewest = min((sample.n for sample in samples), default=0)
        return Sample.pooled(
            Sample(tuple(sorted(sample.rows, key=lambda row: row.seed)[:fewest])) for sample in samples
        )

    def grasps_with(self, *hands: str) -> Sample:
        """Return all attempts at a single grasp with these end-effectors as one sample."""
        return Sample.pooled(self.grasp_samples(*hands))

    def grasp_samples(self, *hands: str) -> list[Sample]:
        """Return all attempts at a single grasp with these end-effectors, one sample for each condition."""
        return [sample for key, sample in self.samples.items() if self.hands.get(key) in hands]

    def __iter__(self) -> Iterator[Sample]:
        """Return the samples, one for each condition."""
        return iter(self.samples.values())
