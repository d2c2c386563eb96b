"""Claims C1 to C5: object models, end-effectors and strategies, with a support."""

from __future__ import annotations

from pilegrasp_ctrl.scenarios.paper.conditions import HAND, HAND_NAMES, OBJECT_NAMES, SHOVEL, grasp
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence, Sample
from pilegrasp_ctrl.scenarios.paper.figures_objects import (
    ROUNDNESS_NAMES,
    STRATEGY_CASES,
    roundness_grid,
    strategy_pair,
)
from pilegrasp_ctrl.scenarios.paper.judgement import (
    Claim,
    Finding,
    Judgement,
    judge_at_least,
    judge_below,
    judge_greater,
    judge_not_above,
    judge_not_less,
)

ROUND_NAMES = {object_model: name for object_model, name in OBJECT_NAMES.items() if object_model != "cube"}
"""Round object models in the paper's words."""


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
    return Finding((judge_at_least(f"shovel, {light[0]}", light[1], 0.85),), samples, remark=remark if high else "")


def _judge_strategies(evidence: Evidence) -> Finding:
    parts: list[Judgement] = []
    samples: dict[str, Sample] = {}
    for object_model, support in STRATEGY_CASES:
        pile, chosen = (evidence.sample(condition) for condition in strategy_pair(object_model, support))
        case = f"{OBJECT_NAMES[object_model]}, {support}"
        samples |= {f"{case}, pile-based": pile, f"{case}, object-based": chosen}
        parts.append(judge_not_above(f"{case}: object-based", chosen, "pile-based", pile))
    return Finding(tuple(parts), samples)


def _judge_roundness(evidence: Evidence) -> Finding:
    parts: list[Judgement] = []
    samples: dict[str, Sample] = {}
    for hand, word in HAND_NAMES.items():
        pooled = {
            name: evidence.balanced_sample(roundness_grid(object_model, hand))
            for object_model, name in ROUNDNESS_NAMES.items()
        }
        samples |= {f"{word}, {name}": sample for name, sample in pooled.items()}
        balls, cylinders, cubes = pooled.values()
        parts += [
            judge_at_least(f"{word}, spheres", balls, 0.8),
            judge_at_least(f"{word}, cylinders", cylinders, 0.8),
            judge_below(f"{word}, cubes", cubes, 0.5),
            judge_not_less(f"{word}, spheres", balls, "cylinders", cylinders),
            judge_greater(f"{word}, cylinders", cylinders, "cubes", cubes),
        ]
    return Finding(tuple(parts), samples)


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
        "shovel, wall: light spheres at least 85 %; the gap to the real shovel is stated",
        _judge_shovel,
        [grasp("light_sphere", "wall", SHOVEL)],
    ),
    Claim(
        "C4",
        "V-B, Fig. 6",
        "Choosing an object never outperforms heeding the pile alone.",
        "object-based never outperforms pile-based",
        "in none of the six pairs is the object-based strategy's rate above the pile-based one's",
        _judge_strategies,
        [condition for case in STRATEGY_CASES for condition in strategy_pair(*case)[1:]],
    ),
    Claim(
        "C5",
        "V-C, Fig. 7",
        "The rounder the objects, the better.",
        "mean at least 80 % for spheres and cylinders, below 50 % for cubes; same order in simulation",
        "means over the grid: spheres and cylinders at least 80 %, cubes below 50 %, spheres >= cylinders > cubes, "
        "for hand and for shovel",
        _judge_roundness,
        [*roundness_grid("cylinder", HAND), *roundness_grid("cube", HAND)],
    ),
)
"""Claims C1 to C5, in the order of their names."""
