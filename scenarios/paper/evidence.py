"""What a store knows, asked by condition."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from pilegrasp_ctrl.scenarios.paper.sample import Sample
from pilegrasp_ctrl.study.attempt import AttemptRow
from pilegrasp_ctrl.study.condition import Condition


@dataclass(frozen=True)
class Evidence:
    """The attempts of a store.

    Attributes:
        samples: by the hash of their configuration.
        hands: the end-effector by the same hash, where an attempt is a single grasp and no order.
    """

    samples: dict[str, Sample]
    hands: dict[str, str]

    @classmethod
    def of_rows(cls, rows: Iterable[AttemptRow], conditions: Iterable[Condition]) -> Evidence:
        """Sort attempts by their configuration; those of other conditions are left out."""
        known = {condition.config_hash: condition.scenario for condition in conditions}
        groups: dict[str, list[AttemptRow]] = {}
        for row in rows:
            if row.config_hash in known:
                groups.setdefault(row.config_hash, []).append(row)
        hands: dict[str, str] = {key: scenario.hand for key, scenario in known.items() if not scenario.support.bin}
        return cls({key: Sample(tuple(group)) for key, group in groups.items()}, hands)

    def of(self, *conditions: Condition) -> Sample:
        """Return the attempts at one condition, or at several as one sample."""
        return Sample.pooled(self.samples.get(condition.config_hash, Sample(())) for condition in conditions)

    def of_all(self, conditions: Iterable[Condition]) -> Sample:
        """Return as many attempts of each of several conditions as one sample, those with the lowest seeds.

        So its rate is the mean over the conditions, though some were run more often for the sake of another figure. It
        is empty while one of them has not been run.
        """
        samples = [self.of(condition) for condition in conditions]
        fewest = min((sample.n for sample in samples), default=0)
        return Sample.pooled(
            Sample(tuple(sorted(sample.rows, key=lambda row: row.seed)[:fewest])) for sample in samples
        )

    def grasps(self, *hands: str) -> Sample:
        """Return all attempts at a single grasp with these end-effectors."""
        return Sample.pooled(self.conditions(*hands))

    def conditions(self, *hands: str) -> list[Sample]:
        """Return the attempts at a single grasp with these end-effectors, one sample a condition."""
        return [sample for key, sample in self.samples.items() if self.hands.get(key) in hands]

    def __iter__(self) -> Iterator[Sample]:
        """Return the samples, one a condition."""
        return iter(self.samples.values())
