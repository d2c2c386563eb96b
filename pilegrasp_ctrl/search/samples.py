"""What a search knows of the attempts of a candidate, and what it wants of them: the objectives."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..config import Scenario
from ..programs.pick_order import CARRY_SPEED, RELEASE_TIME
from ..study.attempt import AttemptRow
from ..types import Array

DELIVERY_WAY = 0.6
"""Way from the end of a lift to the place of delivery, which is also the way back [m]; chosen, from bin to crate."""

RETURN_WAY = 0.3
"""Way from the end of a failed attempt back to its start [m]; chosen."""

LOST_TIME = 60.0
"""Time that an attempt costs which raised, such as one whose pose is out of reach [s]; the limit of an attempt."""


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """The attempts of one candidate on the first n seeds in W worlds.

    Attributes:
        score: (n, W) scores in [0, 1].
        time: (n, W) times of the whole cycle [s].
        peak: (n, W) largest forces at the wrist during push and grasp [N]; NaN where there was neither.
    """

    score: Array
    time: Array
    peak: Array

    @classmethod
    def of(cls, rows: Sequence[Sequence[AttemptRow]], objective: Objective, scenario: Scenario) -> Samples:
        """Return the samples of rows, one list for each seed with a row for each world."""
        delivers = scenario.traits.delivers
        score = [[objective.score(row, scenario) for row in worlds] for worlds in rows]
        time = [[_cycle_time(row, delivers) for row in worlds] for worlds in rows]
        peak = [[_peak(row) for row in worlds] for worlds in rows]
        return cls(*(np.array(values, dtype=np.float64) for values in (score, time, peak)))

    def __len__(self) -> int:
        """Return the number of seeds."""
        return len(self.score)

    def part(self, first: int = 0, last: int | None = None) -> Samples:
        """Return the samples of the seeds from `first` to `last`, the last one left out."""
        return Samples(self.score[first:last], self.time[first:last], self.peak[first:last])

    @property
    def picks_an_hour(self) -> float:
        """Attempts that held something, times their score, in an hour of whole cycles, over all worlds [1/h]."""
        return 3600.0 * float(self.score.sum() / self.time.sum()) if self.score.size else 0.0

    @property
    def median_peak(self) -> float:
        """Median of the largest forces at the wrist [N]; 0 if there is none."""
        known = self.peak[np.isfinite(self.peak)]
        return float(np.median(known)) if known.size else 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Objective:
    """What a search makes large.

    Attributes:
        name: Name on the command line.
        words: What its value is, for pages.
        score: Function from an attempt and its scenario to a score in [0, 1].
        timed: Whether the value is scores an hour, rather than the mean score.
    """

    name: str
    words: str
    score: Callable[[AttemptRow, Scenario], float]
    timed: bool = False

    def value(self, samples: Samples) -> float:
        """Return the value of a candidate: the mean score in its worst world, or the scores an hour."""
        if self.timed:
            return samples.picks_an_hour
        return float(samples.score.mean(axis=0).min()) if len(samples) else 0.0

    def leads(self, one: Samples, other: Samples, rate: float) -> list[list[Array]]:
        """Return by how much one candidate leads another on each seed: (n,) differences in [-1, 1].

        The lists hold the worlds of `other`, and in each the worlds of `one`. The robust value of `one` is the higher
        one if, for some world of `other`, it leads in all of its own worlds.

        With a timed objective a candidate has the higher rate than r if its scores less r times its times are positive.
        Two candidates are compared at the rate of the better one.

        Args:
            one: Samples of a candidate.
            other: Samples of another one, on the same seeds.
            rate: Scores in a second at which times count [1/s].
        """
        count = min(len(one), len(other))
        own, others = one.part(0, count), other.part(0, count)
        found = []
        for theirs in range(others.score.shape[1]):
            row = []
            for mine in range(own.score.shape[1]):
                difference = own.score[:, mine] - others.score[:, theirs]
                if self.timed:
                    late = own.time[:, mine] - others.time[:, theirs]
                    difference = np.clip(difference - rate * late, -2.0, 2.0) / 2.0
                row.append(difference)
            found.append(row)
        return found


OBJECTIVES = {
    objective.name: objective
    for objective in (
        Objective("held", "share of attempts that held something", lambda row, scenario: float(row.success)),
        Objective(
            "single",
            "share of attempts that held exactly one object",
            lambda row, scenario: float(row.success and row.grasped == 1),
        ),
        Objective("picks", "picks an hour", lambda row, scenario: _picked(row, scenario), timed=True),
        Objective("robust", "share that held something in the worst world", lambda row, scenario: float(row.success)),
    )
}
"""Objectives by their names on the command line."""


def _picked(row: AttemptRow, scenario: Scenario) -> float:
    """Return 1 for an attempt that held something; for an order, the share of it that was delivered."""
    if scenario.traits.delivers:
        return min(row.grasped / scenario.order.count, 1.0)
    return float(row.success)


def _cycle_time(row: AttemptRow, delivers: bool) -> float:
    """Return the time of an attempt, of the way to a place of delivery, and of the way back [s]."""
    if row.result is None:
        return LOST_TIME
    time = float(row.result.get("sim_time", LOST_TIME))
    if delivers:
        return time
    return time + (2.0 * DELIVERY_WAY / CARRY_SPEED + RELEASE_TIME if row.success else RETURN_WAY / CARRY_SPEED)


def _peak(row: AttemptRow) -> float:
    outcomes: Sequence[dict[str, Any]] = () if row.result is None else row.result["outcomes"]
    forces = [float(each.get("peak_force", 0.0)) for each in outcomes if each["name"] in ("push", "grasp")]
    return max(forces, default=float("nan"))
