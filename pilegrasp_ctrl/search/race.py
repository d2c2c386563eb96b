"""The race: candidates get more and more common seeds, and those that are surely not the best leave.

The first attempts of every candidate serve its proposal. Then the upper half of those that are left doubles its
attempts, again and again (successive halving; K. Jamieson and A. Talwalkar, AISTATS 2016). Halving only decides who
gets more attempts. A candidate is eliminated where another one leads so clearly that the best candidate is eliminated
with a probability of at most `ERROR`, however often the race looks (successive elimination; E. Even-Dar et al.,
J. Mach. Learn. Res. 7 (2006), p. 1079, with the evidence of `evidence.py`). That evidence begins after the seeds of the
proposals, because a proposal depends on what earlier candidates did on those.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from . import MAX_CANDIDATES
from .evidence import log_evidence
from .proposals import BATCH, Proposer
from .samples import Objective, Samples
from .space import Space

FIRST = 8
"""Seeds that each candidate runs before it is compared (chosen); fewer if the budget is too small for that."""

LEAST = 2
"""Smallest number of such seeds (chosen); a budget for so few serves to try out a search."""

ERROR = 0.05
"""Probability that the best candidate is ever eliminated [-]; chosen, as usual."""

ATTEMPTS_PER_CANDIDATE = 32
"""Attempts of the budget for which one candidate is proposed (chosen): a quarter of them serve proposals."""

MIN_CANDIDATES = 4
"""Smallest number of candidates, the start included (chosen)."""


FINALISTS = 4
"""Number of candidates that are not halved any more (chosen)."""


@dataclass(slots=True, eq=False)
class Candidate:
    """A combination of values.

    Attributes:
        number: Number; 0 is the start.
        values: Values by key.
        samples: Samples so far; None before its first attempt.
        impossible: Reason why it cannot run; "" if it can.
        eliminated_by: Number of the candidate that eliminated it; None if it was not.
        twin: Number of the candidate that means the same; None if there is none.
    """

    number: int
    values: Mapping[str, Any]
    samples: Samples | None = None
    impossible: str = ""
    eliminated_by: int | None = None
    twin: int | None = None

    @property
    def n(self) -> int:
        """Number of seeds so far."""
        return 0 if self.samples is None else len(self.samples)

    @property
    def alive(self) -> bool:
        """Whether it may still be the best."""
        return self.samples is not None and self.eliminated_by is None


Measure = Callable[[Sequence[tuple[Candidate, int]]], None]
"""Function that runs candidates up to a number of seeds, and sets their `samples` or `impossible`."""

Report = Callable[[str, int], None]
"""Callback with what happens now, and the attempts so far."""


@dataclass(slots=True, eq=False)
class Race:
    """A race.

    Attributes:
        space: Space of the candidates.
        objective: What is made large.
        budget: Largest number of attempts.
        worlds: Number of worlds in which each seed is run.
        seeds: Largest number of seeds.
        candidates: Candidates so far, the start first.
        spent: Number of attempts so far.
    """

    space: Space
    objective: Objective
    budget: int
    worlds: int = 1
    seeds: int = 10_000
    candidates: list[Candidate] = field(default_factory=list)
    spent: int = 0

    @property
    def first(self) -> int:
        """Seeds that each candidate runs before it is compared."""
        return max(LEAST, min(FIRST, self.budget // (MIN_CANDIDATES * self.worlds)))

    @property
    def alive(self) -> list[Candidate]:
        """Candidates that may be the best, the highest value first."""
        return sorted(
            (each for each in self.candidates if each.alive), key=lambda each: (-self.value(each), each.number)
        )

    @property
    def finalists(self) -> list[Candidate]:
        """Those of them with the most attempts."""
        most = max((each.n for each in self.alive), default=0)
        return [each for each in self.alive if each.n == most]

    def value(self, candidate: Candidate) -> float:
        """Return a candidate's value; 0 for one that cannot run."""
        return 0.0 if candidate.samples is None else self.objective.value(candidate.samples)

    def run(self, measure: Measure, report: Report = lambda words, spent: None) -> None:
        """Propose, then race until one candidate is left, or the budget or the seeds are used up."""
        self._propose(measure, report)
        while len(self.alive) > 1:
            chosen = self._next_heat()
            if not chosen:
                return
            report(f"{len(self.alive)} candidates left", self.spent)
            self._measure(chosen, measure)
            self._eliminate()
        report("one candidate left", self.spent)

    def _propose(self, measure: Measure, report: Report) -> None:
        wanted = min(MAX_CANDIDATES, max(MIN_CANDIDATES, self.budget // (ATTEMPTS_PER_CANDIDATE * self.worlds)))
        proposer = Proposer(self.space, wanted - 1)
        start = Candidate(0, dict(self.space.start))
        self.candidates = [start]
        self._measure([(start, self.first)], measure)
        proposer.tell_start(self.value(start))
        while len(self.candidates) < wanted and self.spent + self.first * self.worlds <= self.budget:
            proposals = proposer.ask(min(BATCH, wanted - len(self.candidates)))
            if not proposals:
                return
            owners = [self._candidate(values) for _, values in proposals]
            report(f"candidate {len(self.candidates)} of {wanted}", self.spent)
            new = {each.number: (each, self.first) for each in owners if each.samples is None and not each.impossible}
            self._measure(list(new.values()), measure)
            proposer.tell(proposals, [self.value(each) for each in owners])

    def _candidate(self, values: Mapping[str, Any]) -> Candidate:
        """Return the candidate with these values, a new one if there is none."""
        for candidate in self.candidates:
            if candidate.values == values:
                return candidate
        self.candidates.append(Candidate(len(self.candidates), values))
        return self.candidates[-1]

    def _measure(self, wanted: Sequence[tuple[Candidate, int]], measure: Measure) -> None:
        before = {candidate.number: candidate.n for candidate, _ in wanted}
        measure(wanted)
        self.spent += sum(self.worlds * (candidate.n - before[candidate.number]) for candidate, _ in wanted)

    def _next_heat(self) -> list[tuple[Candidate, int]]:
        """Return the candidates that run next, and up to how many seeds; none if there is no room for another heat."""
        finalists = self.finalists
        level = finalists[0].n
        if len(finalists) == 1:
            chosen = [each for each in self.alive if each.n < level][: FINALISTS - 1]
        else:
            chosen = finalists[: max(FINALISTS, math.ceil(len(finalists) / 2))]
            level *= 2
        # The last heat is as long as the budget allows.
        room = (self.budget - self.spent) // self.worlds + sum(each.n for each in chosen)
        level = min(level, self.seeds, room // len(chosen))
        return [(each, level) for each in chosen] if level > max(each.n for each in chosen) else []

    def _eliminate(self) -> None:
        """Eliminate every candidate that another one leads too clearly."""
        alive, rate = self.alive, self.rate()
        for leader in alive[:2]:
            for other in alive:
                if other is not leader and leader.alive and self.evidence(leader, other, rate) >= self.threshold:
                    other.eliminated_by = leader.number

    @property
    def threshold(self) -> float:
        """Logarithm of the evidence that eliminates a candidate."""
        return math.log(len(self.candidates) * self.worlds / ERROR)

    def rate(self) -> float:
        """Return the leader's scores in a second, at which times count [1/s]."""
        if not self.objective.timed:
            return 0.0
        samples = self.alive[0].samples
        return 0.0 if samples is None else samples.picks_an_hour / 3600.0

    def evidence(self, leader: Candidate, other: Candidate, rate: float) -> float:
        """Return the logarithm of the evidence that `leader` is better than `other`, at `rate` scores a second."""
        if leader.samples is None or other.samples is None:
            return 0.0
        leads = self.objective.leads(leader.samples.part(self.first), other.samples.part(self.first), rate)
        return max(min(log_evidence(lead) for lead in row) for row in leads)
