"""The ablation of a winner: which of its changes suffice, by putting keys back to the start one after the other.

This is backward elimination on the seeds of the judgement. In each round every changed key is put back by itself. Of
the candidates that are not worse than the winner, the one with the highest value goes on. The rounds end when none is
left. Each candidate is compared with the winner, not with the round before, so that small losses do not add up.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from .judgement import judge
from .samples import Objective, Samples

MARGIN = 0.10
"""Loss against the winner that still counts as not worse: 10 points, or 10 % of the picks an hour [-]; chosen, as in
the comparisons of the paper's claims."""


@dataclass(frozen=True, slots=True)
class AblationStep:
    """A candidate of the ablation.

    Attributes:
        round: Number of the round, from 1.
        back: Key that this round puts back to the start.
        kept: Changes that are left.
        value: Value on the seeds of the judgement; None if the candidate cannot run.
        low: Lower end of the 95 % interval of its gain over the winner.
        high: Upper end of the interval.
        suffices: Whether it is not worse than the winner: the interval lies above -`MARGIN`.
        chosen: Whether the next round goes on from it.
    """

    round: int
    back: str
    kept: Mapping[str, Any]
    value: float | None
    low: float
    high: float
    suffices: bool
    chosen: bool = False


@dataclass(frozen=True, slots=True)
class Ablation:
    """The result of an ablation.

    Attributes:
        steps: Candidates, in the order of the rounds.
        smallest: Smallest change that was found not to be worse than the winner.
    """

    steps: tuple[AblationStep, ...]
    smallest: Mapping[str, Any]


Run = Callable[[Mapping[str, Any]], Samples | None]
"""Function that runs the start with some changes on the seeds of the judgement; None if it cannot run."""


def changes(start: Mapping[str, Any], winner: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of the winner that differ from those of the start."""
    return {key: value for key, value in winner.items() if value != start[key]}


def most_candidates(keys: int) -> int:
    """Return the largest number of candidates of an ablation of some keys."""
    return keys * (keys + 1) // 2


def ablate(objective: Objective, changed: Mapping[str, Any], winner: Samples, run: Run) -> Ablation:
    """Put the changes of a winner back one after the other.

    Args:
        objective: What the search made large.
        changed: Changes of the winner.
        winner: Samples of the winner on the seeds of the judgement.
        run: Function that runs the start with some of the changes.
    """
    steps: list[AblationStep] = []
    left = dict(changed)
    while left:
        number = 1 + (steps[-1].round if steps else 0)
        tried = [_step(objective, number, key, left, winner, run) for key in left]
        enough = [step for step in tried if step.suffices]
        if not enough:
            steps += tried
            break
        best = max(enough, key=lambda step: (step.value or 0.0, step.low))
        steps += [replace(step, chosen=step is best) for step in tried]
        left = dict(best.kept)
    return Ablation(tuple(steps), left)


def _step(
    objective: Objective, number: int, key: str, left: Mapping[str, Any], winner: Samples, run: Run
) -> AblationStep:
    kept = {each: value for each, value in left.items() if each != key}
    samples = run(kept)
    if samples is None:
        return AblationStep(number, key, kept, None, -1.0, 0.0, False)
    found = judge(objective, winner, samples)
    return AblationStep(number, key, kept, found.winner, found.low, found.high, found.low > -MARGIN)
