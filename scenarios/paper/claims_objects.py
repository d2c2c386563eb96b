"""Claims C1 to C5: object models, end-effectors and strategies, with a support."""

from __future__ import annotations

from dataclasses import replace

from pilegrasp_ctrl.scenarios.paper.comparisons import p_not_inferior, stratified_limits
from pilegrasp_ctrl.scenarios.paper.conditions import HAND, HAND_NAMES, OBJECT_NAMES, SHOVEL, grasp
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence, Sample, pairs
from pilegrasp_ctrl.scenarios.paper.figures_objects import (
    ROUNDNESS_NAMES,
    STRATEGY_CASES,
    roundness_grid,
    strategy_pair,
)
from pilegrasp_ctrl.scenarios.paper.judgement import (
    LEVEL,
    Claim,
    Finding,
    Judgement,
    Outcome,
    format_rate,
    judge_at_least,
    judge_below,
    judge_greater,
    judge_not_less,
    undecided_reason,
)
from pilegrasp_ctrl.statistics import Z_ONE_SIDED

ROUND_NAMES = {object_model: name for object_model, name in OBJECT_NAMES.items() if object_model != "cube"}
"""Round object models in the paper's words."""
MARGIN = 0.1
"""Largest loss of the pile-based strategy against the object-based one that C4 allows, as a share; claims, C4."""


def _beside_wall(evidence: Evidence, hand: str) -> dict[str, Sample]:
    return evidence.samples_of({name: grasp(object_model, "wall", hand) for object_model, name in ROUND_NAMES.items()})


def _judge_round_objects(evidence: Evidence) -> Finding:
    samples = _beside_wall(evidence, HAND)
    return Finding(tuple(judge_at_least(name, sample, 0.95) for name, sample in samples.items()), samples)


def _judge_cubes(evidence: Evidence) -> Finding:
    parts: list[Judgement] = []
    samples: dict[str, Sample] = {}
    for hand, word in HAND_NAMES.items():
        cubes = evidence.sample(grasp("cube", "wall", hand))
        samples[f"{word}, cubes"] = cubes
        parts.append(judge_below(f"{word}, cubes", cubes, 0.5))
        for name, sample in _beside_wall(evidence, hand).items():
            samples[f"{word}, {name}"] = sample
            parts.append(judge_greater(f"{word}, {name}", sample, "cubes", cubes))
    return Finding(tuple(parts), samples)


def _judge_shovel(evidence: Evidence) -> Finding:
    samples = _beside_wall(evidence, SHOVEL)
    light, *others = samples.items()
    known = [f"{name} {100 * sample.rate:.0f} %" for name, sample in others if sample.n]
    remark = (
        "The paper's real shovel was poor for "
        + " and ".join(name for name, _ in others)
        + f"; here: {', '.join(known)}. "
        "Like the paper's own simulation, this one lies far above the real shovel there."
    )
    high = known and all(sample.rate > 0.5 for _, sample in others)
    part = replace(judge_at_least(f"shovel, {light[0]}", light[1], 0.85), calibrated=True)
    return Finding((part,), samples, remark=remark if high else "")


def _judge_strategies(evidence: Evidence) -> Finding:
    parts: list[Judgement] = []
    samples: dict[str, Sample] = {}
    strata = []
    for object_model, support in STRATEGY_CASES:
        pile, chosen = (evidence.sample(condition) for condition in strategy_pair(object_model, support))
        case = f"{OBJECT_NAMES[object_model]}, {support}"
        samples |= {f"{case}, pile-based": pile, f"{case}, object-based": chosen}
        strata.append(pairs(pile, chosen))
        _, only, other, _ = strata[-1]
        text = f"{case}: pile-based {format_rate(pile)}, object-based {format_rate(chosen)}, {only} pairs to {other}"
        parts.append(Judgement(text, reported=True))
    mean, lowest, _ = stratified_limits(strata, Z_ONE_SIDED)
    p = p_not_inferior(tuple(strata), MARGIN)
    text = (
        f"six pairs together: pile-based minus object-based {100 * mean:+.1f} points, at least {100 * lowest:+.1f} "
        f"with 95 %, {-100 * MARGIN:+.0f} asked"
    )
    reason = undecided_reason(*samples.values())
    outcome: Outcome = "holds" if p < LEVEL else "fails" if 1.0 - p < LEVEL else "undecided"
    whole = Judgement(text + reason, "undecided" if reason else outcome)
    numbers = {"difference": mean, "lowest": lowest, "p": p, "pairs": sum(map(sum, strata))}
    return Finding((whole, *parts), samples, numbers)


def _judge_roundness(evidence: Evidence) -> Finding:
    pooled = {
        hand: {
            name: evidence.balanced_sample(roundness_grid(object_model, hand))
            for object_model, name in ROUNDNESS_NAMES.items()
        }
        for hand in HAND_NAMES
    }
    balls, cylinders, cubes = pooled[HAND].values()
    parts = [
        judge_at_least("hand, spheres", balls, 0.8),
        judge_at_least("hand, cylinders", cylinders, 0.8),
        judge_below("hand, cubes", cubes, 0.5),
        *_roundness_order("hand", *pooled[HAND].values()),
        *(replace(part, calibrated=True) for part in _roundness_order("shovel", *pooled[SHOVEL].values())),
    ]
    samples = {f"{HAND_NAMES[hand]}, {name}": s for hand, found in pooled.items() for name, s in found.items()}
    return Finding(tuple(parts), samples)


def _roundness_order(word: str, balls: Sample, cylinders: Sample, cubes: Sample) -> tuple[Judgement, Judgement]:
    return (
        judge_not_less(f"{word}, spheres", balls, "cylinders", cylinders),
        judge_greater(f"{word}, cylinders", cylinders, "cubes", cubes),
    )


CLAIMS = (
    Claim(
        "C1",
        "V-D, Fig. 8",
        "The hand robustly grasps round objects beside a wall.",
        "95 to 100 %",
        "hand, wall, alpha = beta = 0: each of 18 light spheres, 18 heavy spheres and 14 cylinders at least 95 %",
        _judge_round_objects,
        [grasp(object_model) for object_model in ROUND_NAMES],
    ),
    Claim(
        "C2",
        "V-D, Fig. 8",
        "Cubes are hard for both end-effectors.",
        "poor for both",
        "14 cubes below 50 %, and below every round object, for hand and shovel",
        _judge_cubes,
        [grasp("cube"), grasp("cube", "wall", SHOVEL)],
    ),
    Claim(
        "C3",
        "V-D, Fig. 8",
        "The shovel scoops up light spheres.",
        "real: 85 % light, poor for the others; simulation far above reality",
        "shovel, wall: light spheres at least 85 %, calibrated by the tray; the gap to the real shovel is stated",
        _judge_shovel,
        [grasp("light_sphere", "wall", SHOVEL)],
    ),
    Claim(
        "C4",
        "V-B, Fig. 6",
        "Choosing an object never outperforms heeding the pile alone.",
        "object-based never outperforms pile-based",
        "over the six pairs together the pile-based rate is at most 10 points below the object-based one (stratified, "
        "paired, one-sided 95 %)",
        _judge_strategies,
        [condition for case in STRATEGY_CASES for condition in strategy_pair(*case)[1:]],
    ),
    Claim(
        "C5",
        "V-C, Fig. 7",
        "The rounder the objects, the better.",
        "mean at least 80 % for spheres and cylinders, below 50 % for cubes; same order in simulation",
        "hand: means over the grid, spheres and cylinders at least 80 %, cubes below 50 %, spheres >= cylinders > "
        "cubes; the shovel's order with the paper's simulated objects is calibrated by the felt's friction",
        _judge_roundness,
        [*roundness_grid("cylinder", HAND), *roundness_grid("cube", HAND)],
    ),
)
"""Claims C1 to C5, in the order of their names."""
