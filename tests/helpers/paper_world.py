"""Synthetic attempts in which every claim of the paper holds; tests change single conditions."""

from dataclasses import dataclass, field, replace
from functools import cache

from pilegrasp_ctrl.scenarios.paper.conditions import SHOVEL, sized
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.scenarios.paper.figures_mechanism import ORDER_NAMES, PAPER_ATTEMPTS
from pilegrasp_ctrl.scenarios.paper.figures_piles import SIZE_RATIOS, USUAL_PUSH
from pilegrasp_ctrl.scenarios.paper.plan import EXPERIMENTS, extra_conditions, plan
from pilegrasp_ctrl.study.attempt import AttemptRow

TRIGGERS = (("approach", "surface contact"), ("push", "grasp force"), ("grasp", "closed"), ("lift", "lifted"))


@dataclass(frozen=True)
class Made:
    """The numbers of the synthetic attempts at a condition."""

    n: int = 20
    rate: float = 1.0
    several: float = 0.15
    grasped: int = 1
    triggers: tuple = TRIGGERS
    errors: int = 0
    attempts: int | None = None
    measures: dict = field(default_factory=dict)
    separated: float = 1.0


def rows(condition, made):
    """Return the attempts at a condition."""
    successes = round(made.rate * made.n)
    found = []
    for seed in range(made.n):
        if seed >= made.n - made.errors:
            found.append(AttemptRow(condition.config_hash, seed, condition.as_dict(), None, "it broke"))
            continue
        success = seed < successes
        held = (made.grasped + (seed < made.several * successes)) if success else 0
        outcomes = [
            {"name": name, "trigger": trigger, "start": 1.0 + k, "end": 2.0 + k}
            for k, (name, trigger) in enumerate(made.triggers)
        ]
        measures = {
            **made.measures,
            "motion": _motion(made.measures.get("motion", {}), seed, success, seed < made.separated * successes),
        }
        result = {"success": success, "grasped": held, "outcomes": outcomes, "measures": measures, "sim_time": 9.0}
        if made.attempts is not None:
            result["attempts"] = [{}] * made.attempts
        found.append(AttemptRow(condition.config_hash, seed, condition.as_dict(), result, None))
    return found


def _motion(speeds, seed, success, separated):
    """Return the measures of an attempt, spread a little about the mean."""
    varied = {name: speed * (0.9 + 0.05 * (seed % 5)) for name, speed in speeds.items() if isinstance(speed, float)}
    agreed = speeds.get("agreed", True) if success else None
    return (
        {"approach_speed": None, "spread_speed": None}
        | varied
        | {
            "separated": {"stabilised": 2.5 if separated else None},
            "in_hand": ["object_0"],
            "held": ["object_0"] if success else [],
            "agreed": agreed,
            "triggered": True,
        }
    )


def usual(condition):
    """Return the numbers of a condition for which the paper is right."""
    scenario = condition.scenario
    pile, support, shovel = scenario.pile, scenario.support.kind, scenario.hand == SHOVEL
    measures = {"table_force": {"peak": 8.0}, "motion": {"approach_speed": 0.05, "spread_speed": 0.01}}
    if support == "none":
        measures["motion"]["spread_speed"] = 0.03
    if shovel and scenario.controller.kind == "operational_space":
        measures["table_force"]["peak"] = 40.0
    made = Made(measures=measures)
    if scenario.hand == "plate":
        measures["motion"]["approach_speed"] = 0.03
        return replace(made, rate=0.0, separated=0.0)
    if scenario.program == "swap":
        return replace(made, rate=0.3)
    if scenario.name == "bin_picking":
        return replace(made, attempts=round(PAPER_ATTEMPTS[ORDER_NAMES[pile.object]]))
    if condition == USUAL_PUSH:
        return replace(made, rate=0.5)
    if pile.object == "cube":
        return replace(made, rate=0.2)
    if support == "none":
        rate = (0.8 if pile.count >= 60 else 0.1) if shovel else 0.0
        return replace(made, rate=rate, triggers=TRIGGERS if shovel else TRIGGERS[:1])
    if (pile.mass or 0.0) >= 0.36 or scenario.strategy.kind == "object":
        return replace(made, rate=0.4)
    for k, ratio in enumerate(SIZE_RATIOS):
        if condition == sized(ratio):
            return replace(made, grasped=len(SIZE_RATIOS) - k, rate=0.1 if ratio > 1.0 else 1.0)
    return made


@cache
def standard():
    """Return all conditions, and their attempts if the paper is right."""
    conditions = [part.condition for part in plan(EXPERIMENTS.values())]
    return conditions, {condition.config_hash: rows(condition, usual(condition)) for condition in conditions}


def world(changes=(), **everywhere):
    """Return evidence; `changes` are fields of `Made` by condition, and `everywhere` those of all conditions."""
    conditions, found = standard()
    found = dict(found)
    spoilt = [(condition, everywhere) for condition in conditions if everywhere] + list(changes)
    for condition, fields in spoilt:
        found[condition.config_hash] = rows(condition, replace(usual(condition), **fields))
    return Evidence.from_rows(
        (row for attempts in found.values() for row in attempts), conditions, None, extra_conditions()
    )
