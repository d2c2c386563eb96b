"""The attempts of a store by condition, and their counts; and the attempts of a fresh study drawn from them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pilegrasp_ctrl import statistics
from pilegrasp_ctrl.scenarios.paper.columns import Block
from pilegrasp_ctrl.scenarios.paper.comparisons import Pairs
from pilegrasp_ctrl.study.attempt import AttemptRow
from pilegrasp_ctrl.study.condition import Condition
from pilegrasp_ctrl.types import Array

Indices = NDArray[np.intp]
Flags = NDArray[np.bool_]

wilson = lru_cache(maxsize=100_000)(statistics.wilson)
"""Wilson's interval; a bootstrap asks for the same ones again and again."""


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """Attempts at one condition: those of the store, or some drawn from them.

    Attributes:
        block: Attempts of the store.
        drawn: (n,) indices of the attempts in the block.
        noise: (n,) uniform numbers of a fresh study, which smooth its rates; None for the study itself.
    """

    block: Block
    drawn: Indices
    noise: Array | None = None

    def values(self, name: str) -> Array:
        """Return a column of the attempts (n,)."""
        return self.block.column(name)[self.drawn]

    def first(self, n: int) -> Part:
        """Return the first n attempts."""
        return Part(self.block, self.drawn[:n], None if self.noise is None else self.noise[:n])


@dataclass(frozen=True, eq=False)
class Sample:
    """The attempts of one condition, or of several that are judged together. One that raised has no success.

    Attributes:
        parts: Attempts by condition.
    """

    parts: tuple[Part, ...] = ()
    _flags: dict[str, Flags] = field(default_factory=dict, repr=False)

    @classmethod
    def of(cls, rows: Iterable[AttemptRow]) -> Sample:
        """Return the attempts at one condition as a sample."""
        block = Block(tuple(rows))
        return cls((Part(block, np.arange(len(block.rows))),)) if block.rows else cls()

    @classmethod
    def pooled(cls, samples: Iterable[Sample]) -> Sample:
        """Return the attempts of all samples as one."""
        return cls(tuple(part for sample in samples for part in sample.parts))

    @property
    def rows(self) -> tuple[AttemptRow, ...]:
        """Attempts, by condition and seed."""
        return tuple(part.block.rows[index] for part in self.parts for index in part.drawn)

    @cached_property
    def n(self) -> int:
        """Number of attempts."""
        return sum(part.drawn.size for part in self.parts)

    def flags(self, name: str) -> Flags:
        """Return a truth of every attempt (n,).

        In a fresh study one attempt in n + 1 is a fair coin. Its rate then is Jeffreys' estimate, (x + 1/2) / (n + 1),
        and 50 of 50 can become 49.
        """
        if name not in self._flags:
            self._flags[name] = self._read(name)
        return self._flags[name]

    def _read(self, name: str) -> Flags:
        if not self.parts:
            return np.zeros(0, dtype=bool)
        flags = np.concatenate([part.values(name) for part in self.parts]) > 0.5
        if self.parts[0].noise is not None:
            noise = np.concatenate([part.noise for part in self.parts if part.noise is not None])
            share = 1.0 / (noise.size + 1)
            flags = np.where(noise < share, noise < 0.5 * share, flags)
        return flags

    def count(self, name: str) -> int:
        """Return in how many attempts something is true."""
        return int(np.count_nonzero(self.flags(name)))

    def numbers(self, name: str) -> Array:
        """Return a number of every attempt that has it."""
        if not self.parts:
            return np.zeros(0)
        found = np.concatenate([part.values(name) for part in self.parts])
        return found[~np.isnan(found)]

    def mean(self, name: str) -> float | None:
        """Return the mean of a number over the attempts that have it, or None without any."""
        found = self.numbers(name)
        return float(found.mean()) if found.size else None

    @property
    def successes(self) -> int:
        """Number of attempts that held an object."""
        return self.count("success")

    @property
    def errors(self) -> int:
        """Number of attempts that raised."""
        return int(sum(np.count_nonzero(part.values("error")) for part in self.parts if part.block.broken))

    @property
    def rate(self) -> float:
        """Share of successes; 0 of 0 is 0."""
        return self.successes / self.n if self.parts else 0.0

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % Wilson interval of the rate; [0, 1] without attempts."""
        return wilson(self.successes, self.n)

    @property
    def mean_grasped(self) -> float:
        """Mean number of objects held, failures counted as 0."""
        return self.mean("grasped") or 0.0

    def first(self, n: int) -> Sample:
        """Return the first n attempts at each condition, those with the lowest seeds."""
        return Sample(tuple(part.first(n) for part in self.parts))

    def as_dict(self) -> dict[str, Any]:
        """Return the counts as plain JSON values."""
        low, high = self.interval
        counts = {key: self.count(name) for key, name in (("multiple", "several"), ("triggered", "triggered"))}
        return {
            "n": self.n,
            "successes": self.successes,
            "rate": self.rate if self.parts else None,
            "ci_low": low,
            "ci_high": high,
            **counts,
            "errors": self.errors,
        }


EMPTY = Sample()
"""No attempts."""


def pairs(first: Sample, second: Sample, name: str = "success") -> Pairs:
    """Return how many pairs of equal seeds are true in both, in the first only, in the second only, and in neither.

    Args:
        first: Attempts at one condition.
        second: Attempts at another one, with the same piles.
        name: Truth that is compared.
    """
    here, there = _aligned(first, second)
    a, b = first.flags(name)[here], second.flags(name)[there]
    both, only = int(np.count_nonzero(a & b)), int(np.count_nonzero(a & ~b))
    other = int(np.count_nonzero(b & ~a))
    return both, only, other, int(a.size) - both - only - other


def differences(first: Sample, second: Sample, name: str) -> Array:
    """Return the differences of a number between the attempts with equal seeds, where both have it."""
    here, there = _aligned(first, second)
    if not here.size:
        return np.zeros(0)
    found = first.parts[0].values(name)[here] - second.parts[0].values(name)[there]
    return found[~np.isnan(found)]


def _aligned(first: Sample, second: Sample) -> tuple[Indices, Indices]:
    """Return the places of the attempts with equal seeds in two samples of one condition each.

    The attempts of a fresh study are drawn for all conditions at once, so they pair by their place.
    """
    if not first.parts or not second.parts:
        none = np.zeros(0, dtype=int)
        return none, none
    (one,), (other,) = first.parts, second.parts
    if one.noise is not None:
        places = np.arange(min(one.drawn.size, other.drawn.size))
        return places, places
    seeds, others = ([part.block.rows[index].seed for index in part.drawn] for part in (one, other))
    _, here, there = np.intersect1d(seeds, others, assume_unique=True, return_indices=True)
    return here, there


@dataclass(frozen=True)
class Evidence:
    """The attempts of a store; iterating gives the samples, one for each condition.

    Attributes:
        samples: Attempts by the hash of their configuration.
        hands: End-effectors by the same hash, for the single grasps of the paper's experiments only.
    """

    samples: dict[str, Sample]
    hands: dict[str, str] = field(default_factory=dict)
    _grasps: dict[tuple[str, ...], Sample] = field(default_factory=dict, repr=False)

    @classmethod
    def from_rows(
        cls,
        rows: Iterable[AttemptRow],
        conditions: Iterable[Condition],
        run_as: Mapping[str, str] | None = None,
        extra: Iterable[str] = (),
    ) -> Evidence:
        """Return the attempts by their condition; attempts at other conditions are left out.

        Args:
            rows: Attempts.
            conditions: Conditions of the experiments.
            run_as: Hash with which each condition was run, by its own hash; its own if absent.
            extra: Hashes of conditions that are no grasp of the paper's, such as null models.
        """
        known = {condition.config_hash: condition.scenario for condition in conditions}
        stored: dict[str, list[str]] = {}
        for key in known:
            stored.setdefault((run_as or {}).get(key, key), []).append(key)
        groups: dict[str, list[AttemptRow]] = {}
        for row in rows:
            for key in stored.get(row.config_hash, ()):
                groups.setdefault(key, []).append(row)
        left_out = set(extra)
        hands: dict[str, str] = {
            key: scenario.hand for key, scenario in known.items() if not scenario.support.bin and key not in left_out
        }
        return cls({key: Sample.of(group) for key, group in groups.items()}, hands)

    def sample(self, *conditions: Condition) -> Sample:
        """Return the attempts at one condition, or at several as one sample."""
        found = [self.samples.get(condition.config_hash, EMPTY) for condition in conditions]
        return found[0] if len(found) == 1 else Sample.pooled(found)

    def samples_of(self, conditions: Mapping[str, Condition]) -> dict[str, Sample]:
        """Return the attempts at each condition, by the same names."""
        return {name: self.sample(condition) for name, condition in conditions.items()}

    def balanced_sample(self, conditions: Iterable[Condition]) -> Sample:
        """Return equally many attempts of several conditions as one sample, the attempts with the lowest seeds.

        Its rate is therefore the mean over the conditions, although another figure may need more attempts at some of
        them. The sample is empty while one condition has no attempts.
        """
        samples = [self.sample(condition) for condition in conditions]
        fewest = min((sample.n for sample in samples), default=0)
        return Sample.pooled(sample.first(fewest) for sample in samples) if fewest else Sample()

    def grasps_with(self, *hands: str) -> Sample:
        """Return all attempts at a single grasp of the paper with these end-effectors as one sample."""
        if hands not in self._grasps:
            chosen = (sample for key, sample in self.samples.items() if self.hands.get(key) in hands)
            self._grasps[hands] = Sample.pooled(chosen)
        return self._grasps[hands]

    def fresh(self, random: np.random.Generator) -> Evidence:
        """Return a study of the same size that could have come out instead.

        Seeds are drawn with replacement, the same for all conditions, so that pairs stay pairs. Conditions have fewer
        or more attempts: seeds that only larger ones have are drawn among themselves.
        """
        sizes = sorted({sample.n for sample in self.samples.values()})
        noise = random.random(sum(sample.n for sample in self.samples.values()))
        used = 0
        limits = zip([0, *sizes], sizes, strict=False)
        drawn = np.concatenate([random.integers(low, high, high - low) for low, high in limits] or [np.zeros(0, int)])
        samples = {}
        for key, sample in self.samples.items():
            (part,) = sample.parts
            samples[key] = Sample((Part(part.block, drawn[: sample.n], noise[used : used + sample.n]),))
            used += sample.n
        return Evidence(samples, self.hands)

    def __iter__(self) -> Iterator[Sample]:
        """Return the samples, one for each condition."""
        return iter(self.samples.values())
