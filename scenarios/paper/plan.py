"""What is to be run: the conditions of several experiments, each condition once; and what that will cost."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.scenarios.paper import figures_mechanism, figures_objects, figures_piles
from pilegrasp_ctrl.scenarios.paper.experiment import Experiment
from pilegrasp_ctrl.study.condition import Attempt, Condition
from pilegrasp_ctrl.study.store import StudyStore

EXPERIMENTS = {
    experiment.name: experiment
    for figures in (figures_objects, figures_piles, figures_mechanism)
    for experiment in figures.EXPERIMENTS
}
"""All experiments by name, in the order in which they are run and shown."""
USUAL_COST = {"rbo_hand2": 1.5, "shovel": 0.95}
"""Processor time of an attempt with 18 objects, its recording and measures included [s]; up to four times as much on a
machine whose caches other programs use as well."""
SPREAD_PILE_COST = 0.042
"""Additional processor time for each object above 30, most of it spent on letting the pile settle [s]."""
ATTEMPTS_IN_AN_ORDER = 9.0
"""Cost of an order, with what comes between its attempts, over that of an attempt."""


def find_experiment(name: str) -> Experiment:
    """Return an experiment by name.

    Raises:
        ConfigurationError: No experiment has that name.
    """
    if name not in EXPERIMENTS:
        raise ConfigurationError(f"there is no experiment {name!r}; choose from {', '.join(EXPERIMENTS)} or all")
    return EXPERIMENTS[name]


@dataclass(frozen=True, slots=True)
class PlannedCondition:
    """Attempts at one condition.

    Attributes:
        condition: Scenario that is run.
        attempts: Number of attempts, the largest that an experiment asks for.
        experiment: Name of the first experiment that asks for it.
    """

    condition: Condition
    attempts: int
    experiment: str

    def seeded(self, first_seed: int) -> list[Attempt]:
        """Return condition and seed of every attempt."""
        return [(self.condition, first_seed + k) for k in range(self.attempts)]

    def cost(self) -> float:
        """Return the processor time that an attempt is expected to take [s]."""
        scenario = self.condition.scenario
        usual = USUAL_COST[scenario.hand] + SPREAD_PILE_COST * max(0, scenario.pile.count - 30)
        return usual * (ATTEMPTS_IN_AN_ORDER if scenario.name == "bin_picking" else 1.0)


def plan(experiments: Iterable[Experiment], attempts: int | None = None) -> list[PlannedCondition]:
    """Return what the experiments ask for, each condition once.

    Args:
        experiments: What is run.
        attempts: Largest number of attempts at a condition; the paper's numbers if None.
    """
    found: dict[str, PlannedCondition] = {}
    for experiment in experiments:
        for part in experiment.conditions:
            number = part.shortened(attempts)
            known = found.get(part.condition.config_hash)
            if known is None:
                found[part.condition.config_hash] = PlannedCondition(part.condition, number, experiment.name)
            elif number > known.attempts:
                found[part.condition.config_hash] = PlannedCondition(known.condition, number, known.experiment)
    return list(found.values())


@dataclass(frozen=True, slots=True)
class Remaining:
    """What is left to do.

    Attributes:
        attempts: Number of attempts in the plan.
        missing: Number of these that the store does not hold.
        seconds: Processor time that the missing ones are expected to take [s].
    """

    attempts: int
    missing: int
    seconds: float


def count_remaining(planned: Sequence[PlannedCondition], first_seed: int, store: StudyStore | None = None) -> Remaining:
    """Return what is left; a condition of which the store holds attempts costs what those took."""
    costs = store.costs() if store else {}
    measured: dict[str, list[float]] = {}
    for (config_hash, _), (processor, _) in costs.items():
        measured.setdefault(config_hash, []).append(processor)
    missing, seconds = 0, 0.0
    for part in planned:
        key = part.condition.config_hash
        left = sum((key, seed) not in costs for _, seed in part.seeded(first_seed))
        known = measured.get(key)
        missing += left
        seconds += left * (sum(known) / len(known) if known else part.cost())
    return Remaining(sum(part.attempts for part in planned), missing, seconds)
