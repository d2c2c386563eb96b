"""The plan of a run: the conditions of several experiments, each condition once, and the expected processor time."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pilegrasp_ctrl.config import build_scenario
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.scenarios.paper import figures_mechanism, figures_nulls, figures_objects, figures_piles
from pilegrasp_ctrl.scenarios.paper.experiment import Experiment
from pilegrasp_ctrl.study.condition import Attempt, Condition
from pilegrasp_ctrl.study.store import StudyStore

EXPERIMENTS = {
    experiment.name: experiment
    for figures in (figures_objects, figures_piles, figures_mechanism, figures_nulls)
    for experiment in figures.EXPERIMENTS
}
"""All experiments by name, in the order in which they are run and shown."""
USUAL_COST = {"rbo_hand2": 1.5, "shovel": 0.95, "plate": 0.95}
"""Processor time of an attempt with 18 objects by end-effector, with its recording and measures [s]. It is up to four
times as long on a machine whose caches other programs use as well."""
SPREAD_PILE_COST = 0.042
"""Additional processor time for each object above 30 [s]; most of it simulates the settling of the pile."""
ATTEMPTS_IN_AN_ORDER = 9.0
"""Processor time of an order, with the time between its attempts, over that of an attempt."""


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
        condition: Condition to run.
        attempts: Number of attempts; the largest number among the experiments with this condition.
        experiment: Name of the first experiment with this condition.
    """

    condition: Condition
    attempts: int
    experiment: str

    def seeded(self, first_seed: int) -> list[Attempt]:
        """Return condition and seed of every attempt."""
        return [(self.condition, first_seed + k) for k in range(self.attempts)]

    def cost(self) -> float:
        """Return the expected processor time of an attempt [s]."""
        scenario = self.condition.scenario
        usual = USUAL_COST[scenario.hand] + SPREAD_PILE_COST * max(0, scenario.pile.count - 30)
        return usual * (ATTEMPTS_IN_AN_ORDER if scenario.name == "bin_picking" else 1.0)


def with_settings(condition: Condition, settings: Mapping[str, Any]) -> Condition:
    """Return a condition with keys of the user on top of its own; the condition itself without such keys.

    Raises:
        ConfigurationError: The keys cannot be used at this condition.
    """
    if not settings:
        return condition
    values = condition.scenario.model_dump(mode="json")
    try:
        scenario = build_scenario(values, settings)
    except ConfigurationError as error:
        text = ", ".join(f"{key} = {value}" for key, value in condition.varied.items())
        raise ConfigurationError(f"--set does not fit the condition {text}: {error}") from None
    return Condition(scenario, {**condition.varied, **settings})


def plan(
    experiments: Iterable[Experiment], attempts: int | None = None, settings: Mapping[str, Any] | None = None
) -> list[PlannedCondition]:
    """Return the conditions of the experiments, each condition once.

    Args:
        experiments: Experiments to run.
        attempts: Largest number of attempts at a condition; the ledger's numbers if None.
        settings: Dotted keys and values on top of every condition.

    Raises:
        ConfigurationError: The settings cannot be used at one of the conditions.
    """
    found: dict[str, PlannedCondition] = {}
    for experiment in experiments:
        for part in experiment.conditions:
            number = part.shortened(attempts)
            condition = with_settings(part.condition, settings or {})
            known = found.get(condition.config_hash)
            if known is None:
                found[condition.config_hash] = PlannedCondition(condition, number, experiment.name)
            elif number > known.attempts:
                found[condition.config_hash] = PlannedCondition(known.condition, number, known.experiment)
    return list(found.values())


def extra_conditions() -> list[str]:
    """Return the hashes of the conditions that are no grasps of the paper's, such as null models."""
    return [part.condition.config_hash for part in plan(EXPERIMENTS.values()) if EXPERIMENTS[part.experiment].extra]


@dataclass(frozen=True, slots=True)
class Remaining:
    """The rest of a plan that is not in the store yet.

    Attributes:
        attempts: Number of attempts in the plan.
        missing: Number of these attempts that the store does not hold.
        seconds: Expected processor time of the missing attempts [s].
    """

    attempts: int
    missing: int
    seconds: float


def count_remaining(planned: Sequence[PlannedCondition], first_seed: int, store: StudyStore | None = None) -> Remaining:
    """Return the rest of the plan; stored attempts of a condition give the expected time of its missing ones."""
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
