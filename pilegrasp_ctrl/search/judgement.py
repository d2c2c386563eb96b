"""The judgement of a search: the winner against the start, paired on seeds that the search has not seen."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..statistics import Z_ONE_SIDED, mcnemar, paired_limits, wilson
from .samples import Objective, Samples

WORTH = 0.15
"""Gain from which a search has found something: 15 points of a share, or 15 % of the picks an hour [-]; chosen."""

RESAMPLES = 2000
"""Number of resamples of the seeds for an interval that no formula gives (chosen)."""

MIN_JUDGED = 10
"""Smallest number of seeds that decide anything (chosen)."""

RESAMPLING_SEED = 20200312
"""Seed of these resamples (chosen)."""


@dataclass(frozen=True, slots=True, eq=False)
class Judgement:
    """The winner against the start, on fresh seeds.

    Attributes:
        n: Number of seeds.
        start: Value of the start.
        winner: Value of the winner.
        gain: Their difference; for picks an hour, as a share of the start's.
        low: Lower end of the 95 % interval of the gain.
        high: Upper end of the interval.
        bound: Upper one-sided 95 % bound of the gain.
        worlds: For each world both counts, their intervals, and McNemar's test.
        verdict: "better", "worse", "nothing found" or "undecided".
    """

    n: int
    start: float
    winner: float
    gain: float
    low: float
    high: float
    bound: float
    worlds: tuple[dict[str, Any], ...]
    verdict: str


def judge(objective: Objective, start: Samples, winner: Samples) -> Judgement:
    """Compare two candidates on the same seeds."""
    n = min(len(start), len(winner))
    start, winner = start.part(0, n), winner.part(0, n)
    worlds = tuple(_world(start, winner, world) for world in range(start.score.shape[1]))
    values = objective.value(start), objective.value(winner)
    if n < MIN_JUDGED:
        low, high, bound = -1.0, 1.0, 1.0
    elif len(worlds) == 1 and not objective.timed:
        world = worlds[0]
        pairs = world["both"], world["winner_only"], world["start_only"], world["neither"]
        low, high = paired_limits(pairs)
        bound = paired_limits(pairs, Z_ONE_SIDED)[1]
    else:
        low, high, bound = _resampled(objective, start, winner)
    return Judgement(n, *values, _gain(objective, *values), low, high, bound, worlds, verdict_of(low, high, bound))


def verdict_of(low: float, high: float, bound: float) -> str:
    """Return the verdict for the interval of a gain and its one-sided bound."""
    if low > 0.0:
        return "better"
    if high < 0.0:
        return "worse"
    return "nothing found" if bound < WORTH else "undecided"


def _gain(objective: Objective, start: float, winner: float) -> float:
    if not objective.timed:
        return winner - start
    return winner / start - 1.0 if start else float(winner > 0.0)


def _world(start: Samples, winner: Samples, world: int) -> dict[str, Any]:
    one, other = winner.score[:, world] > 0.5, start.score[:, world] > 0.5
    n, wins, losses = len(one), int((one & ~other).sum()), int((other & ~one).sum())
    return {
        "n": n,
        "start": int(other.sum()),
        "winner": int(one.sum()),
        "start_interval": list(wilson(int(other.sum()), n)),
        "winner_interval": list(wilson(int(one.sum()), n)),
        "both": int((one & other).sum()),
        "winner_only": wins,
        "start_only": losses,
        "neither": int((~one & ~other).sum()),
        "p": mcnemar(wins, losses),
    }


def _resampled(objective: Objective, start: Samples, winner: Samples) -> tuple[float, float, float]:
    """Return the 95 % interval of the gain and its one-sided 95 % bound: percentiles over resamples of the seeds."""
    random = np.random.default_rng(RESAMPLING_SEED)
    gains = []
    for _ in range(RESAMPLES):
        rows = random.integers(0, len(start), len(start))
        parts = [Samples(each.score[rows], each.time[rows], each.peak[rows]) for each in (start, winner)]
        gains.append(_gain(objective, *map(objective.value, parts)))
    low, bound, high = np.percentile(gains, [2.5, 95.0, 97.5])
    return float(low), float(high), float(bound)
