"""Claims C1 to C5: kinds of objects, end-effectors and strategies, with a support."""

from __future__ import annotations

from pilegrasp_ctrl.scenarios.paper import fig06, fig07, fig08
from pilegrasp_ctrl.scenarios.paper.claim import Claim, Finding, named
from pilegrasp_ctrl.scenarios.paper.conditions import HAND, SHOVEL, grasp
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.scenarios.paper.judgement import Judgement, at_least, below, greater, never_above, not_less
from pilegrasp_ctrl.scenarios.paper.sample import Sample

ROUND = {kind: name for kind, name in fig08.KINDS.items() if kind != "cube"}
HANDS = {HAND: "hand", SHOVEL: "shovel"}


def _beside_wall(evidence: Evidence, hand: str) -> dict[str, Sample]:
    return named(evidence, {name: grasp(kind, "wall", hand) for kind, name in ROUND.items()})


def _round_objects(evidence: Evidence) -> Finding:
    samples = _beside_wall(evidence, HAND)
    return Finding(tuple(at_least(name, sample, 0.95) for name, sample in samples.items()), samples)


def _cubes(evidence: Evidence) -> Finding:
    parts: list[Judgement] = []
    samples: dict[str, Sample] = {}
    for hand, word in HANDS.items():
        cubes = evidence.of(grasp("cube", "wall", hand))
        samples[f"{word}, cubes"] = cubes
        parts.append(below(f"{word}, cubes", cubes, 0.5))
        for name, sample in _beside_wall(evidence, hand).items():
            samples[f"{word}, {name}"] = sample
            parts.append(greater(f"{word}, {name}", sample, "cubes", cubes))
    return Finding(tuple(parts), samples)


def _shovel(evidence: Evidence) -> Finding:
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
    return Finding((at_least(f"shovel, {light[0]}", light[1], 0.85),), samples, remark=remark if high else "")


def _strategies(evidence: Evidence) -> Finding:
    parts: list[Judgement] = []
    samples: dict[str, Sample] = {}
    for kind, support in fig06.CASES:
        pile, chosen = (evidence.of(condition) for condition in fig06.pair(kind, support))
        case = f"{fig08.KINDS[kind]}, {support}"
        samples |= {f"{case}, pile-based": pile, f"{case}, object-based": chosen}
        parts.append(never_above(f"{case}: object-based", chosen, "pile-based", pile))
    return Finding(tuple(parts), samples)


def _roundness(evidence: Evidence) -> Finding:
    parts: list[Judgement] = []
    samples: dict[str, Sample] = {}
    for hand, word in HANDS.items():
        pooled = {name: evidence.of_all(fig07.grid(kind, hand)) for kind, name in fig07.KINDS.items()}
        samples |= {f"{word}, {name}": sample for name, sample in pooled.items()}
        balls, cylinders, cubes = pooled.values()
        parts += [
            at_least(f"{word}, spheres", balls, 0.8),
            at_least(f"{word}, cylinders", cylinders, 0.8),
            below(f"{word}, cubes", cubes, 0.5),
            not_less(f"{word}, spheres", balls, "cylinders", cylinders),
            greater(f"{word}, cylinders", cylinders, "cubes", cubes),
        ]
    return Finding(tuple(parts), samples)


CLAIMS = (
    Claim(
        "C1",
        "V-D, Fig. 8",
        "The hand robustly grasps round objects beside a wall.",
        "95 to 100 %",
        "hand, wall, alpha = beta = 0: each of 18 light spheres, 18 heavy spheres and 14 cylinders at least 95 %",
        _round_objects,
        [grasp(kind) for kind in ROUND],
    ),
    Claim(
        "C2",
        "V-D, Fig. 8",
        "Cubes are hard for both end-effectors.",
        "poor for both",
        "14 cubes below 50 %, and below every round object, for hand and shovel",
        _cubes,
        [grasp("cube"), grasp("cube", "wall", SHOVEL)],
    ),
    Claim(
        "C3",
        "V-D, Fig. 8",
        "The shovel scoops up light spheres.",
        "real: 85 % light, poor for the others; simulation far above reality",
        "shovel, wall: light spheres at least 85 %; the gap to the real shovel is stated",
        _shovel,
        [grasp("light_sphere", "wall", SHOVEL)],
    ),
    Claim(
        "C4",
        "V-B, Fig. 6",
        "Choosing an object never outperforms heeding the pile alone.",
        "object-based never outperforms pile-based",
        "in none of the six pairs is the object-based strategy's rate above the pile-based one's",
        _strategies,
        [condition for case in fig06.CASES for condition in fig06.pair(*case)[1:]],
    ),
    Claim(
        "C5",
        "V-C, Fig. 7",
        "The rounder the objects, the better.",
        "mean at least 80 % for spheres and cylinders, below 50 % for cubes; same order in simulation",
        "means over the grid: spheres and cylinders at least 80 %, cubes below 50 %, spheres >= cylinders > cubes, "
        "for hand and for shovel",
        _roundness,
        [*fig07.grid("cylinder", HAND), *fig07.grid("cube", HAND)],
    ),
)
