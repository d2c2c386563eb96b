"""What is to be run: the rows of several experiments, each condition once; and what that will cost."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from pilegrasp_ctrl.scenarios.paper.experiment import Experiment
from pilegrasp_ctrl.study.condition import Condition
from pilegrasp_ctrl.study.store import StudyStore

USUAL_COST = {"rbo_hand2": 1.5, "shovel": 0.95}
"""Processor seconds of an attempt with 18 objects, its recording and measures included; up to four times as
many on a machine whose caches other programs use as well."""
COST_OF_A_SPREAD_PILE = 0.042
"""More of them for each object above 30, most of it spent on letting the pile settle."""
ATTEMPTS_IN_AN_ORDER = 9.0
"""Counted by their cost, with what comes between them."""


@dataclass(frozen=True, slots=True)
class Work:
    """Attempts at one condition.

    Attributes:
        condition: what is run.
        attempts: how often, over all experiments that want it.
        experiment: the first that wants it.
    """

    condition: Condition
    attempts: int
    experiment: str

    def pairs(self, first_seed: int) -> list[tuple[Condition, int]]:
        """Return condition and seed of every attempt."""
        return [(self.condition, first_seed + k) for k in range(self.attempts)]

    def cost(self) -> float:
        """Return the processor seconds that an attempt is expected to take."""
        scenario = self.condition.scenario
        usual = USUAL_COST[scenario.hand] + COST_OF_A_SPREAD_PILE * max(0, scenario.pile.count - 30)
        return usual * (ATTEMPTS_IN_AN_ORDER if scenario.name == "bin_picking" else 1.0)


def plan(experiments: Iterable[Experiment], attempts: int | None) -> list[Work]:
    """Return what the experiments want, a condition once: the most that one of them asks for."""
    found: dict[str, Work] = {}
    for experiment in experiments:
        for row in experiment.rows:
            number = row.shortened(attempts)
            known = found.get(row.condition.config_hash)
            if known is None:
                found[row.condition.config_hash] = Work(row.condition, number, experiment.name)
            elif number > known.attempts:
                found[row.condition.config_hash] = Work(known.condition, number, known.experiment)
    return list(found.values())


@dataclass(frozen=True, slots=True)
class Expected:
    """What is left to do.

    Attributes:
        attempts: in all.
        missing: of them, those that the store does not hold.
        seconds: of processor time for these.
    """

    attempts: int
    missing: int
    seconds: float


def expect(work: Sequence[Work], first_seed: int, store: StudyStore | None) -> Expected:
    """Return what is left, at the cost measured in the store where there are attempts at the condition already."""
    costs = store.costs() if store else {}
    measured: dict[str, list[float]] = {}
    for (config_hash, _), (processor, _) in costs.items():
        measured.setdefault(config_hash, []).append(processor)
    missing, seconds = 0, 0.0
    for part in work:
        key = part.condition.config_hash
        left = sum((key, seed) not in costs for _, seed in part.pairs(first_seed))
        known = measured.get(key)
        missing += left
        seconds += left * (sum(known) / len(known) if known else part.cost())
    return Expected(sum(part.attempts for part in work), missing, seconds)
