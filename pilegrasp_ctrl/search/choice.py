"""The choice among candidates that the race could not tell apart."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from .race import Candidate, Race

NEAR = 0.05
"""Share by which picks an hour or the peak force may be worse than the best and still count as equal [-]; chosen."""

RULE = (
    "Of the candidates that are left with the most attempts, those are tied whose distance to the leader is within its "
    "standard error. Of them come first those within 5 % of the most picks an hour, of these those within 5 % of the "
    "smallest peak force at the wrist, and of these the one nearest to the start"
)
"""Rule of the choice."""


def tied(race: Race) -> list[Candidate]:
    """Return the leader and the finalists that are within a standard error of it, the leader first."""
    leader, *others = race.finalists
    return [leader, *(other for other in others if _is_near(race, leader, other))]


def _is_near(race: Race, leader: Candidate, other: Candidate) -> bool:
    if leader.samples is None or other.samples is None:
        return False
    mine, theirs = (int(each.samples.score.mean(axis=0).argmin()) for each in (leader, other) if each.samples)
    lead = race.objective.leads(leader.samples, other.samples, race.rate())[theirs][mine]
    return bool(lead.sum() <= math.sqrt(float((lead * lead).sum())))


def choose(race: Race, candidates: Sequence[Candidate]) -> Candidate:
    """Return one of some tied candidates, by `RULE`."""
    left = _within(list(candidates), lambda each: each.samples.picks_an_hour if each.samples else 0.0, 1.0 - NEAR)
    left = _within(left, lambda each: -each.samples.median_peak if each.samples else 0.0, 1.0 + NEAR)
    return min(left, key=lambda each: (race.space.distance(each.values), each.number))


def _within(candidates: list[Candidate], value: Callable[[Candidate], float], factor: float) -> list[Candidate]:
    """Return the candidates whose value is at least `factor` times the largest; a negative value is a cost."""
    best = max(map(value, candidates))
    return [each for each in candidates if value(each) >= factor * best]
