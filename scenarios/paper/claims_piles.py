"""Claims C6 to C11: number, mass and size of the objects, with and without a support."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

from pilegrasp_ctrl.scenarios.paper.conditions import HAND, SHOVEL, sized, spheres
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence, Sample
from pilegrasp_ctrl.scenarios.paper.figures_piles import (
    COUNT_MASSES,
    HARD_PUSH,
    ROBOT_COUNTS,
    SIZE_RATIOS,
    UNSUPPORTED,
    USUAL_PUSH,
)
from pilegrasp_ctrl.scenarios.paper.judgement import (
    Claim,
    Finding,
    Judgement,
    format_percent,
    format_share,
    judge,
    judge_at_least,
    judge_below,
    judge_greater,
    undecided_reason,
)

SMALL_COUNTS, LARGE_COUNTS = (3, 5, 10, 15, 20), (60, 90)
"""Numbers of objects that C8 compares."""
LIGHT_MASSES, HEAVY_MASSES = (0.03, 0.06), (0.36, 0.72)
"""Masses of an object that C9 compares [kg]."""
MAX_TRIGGERED = 0.1
"""Largest share of the pushes without a support that may reach F_grasp; claims, C6."""
MONOTONE = -0.8
"""Upper bound of the rank correlation in C11; chosen."""


def _judge_unsupported(evidence: Evidence) -> Finding:
    alone = evidence.sample(UNSUPPORTED)
    count = alone.count("triggered")
    text = f"pushes that reach F_grasp: {format_share(count, alone.n)}, at most {format_percent(MAX_TRIGGERED)} asked"
    part = judge(text, count <= MAX_TRIGGERED * alone.n + 1e-9, alone)
    return Finding((part,), {"18 heavy spheres, alone": alone})


def _judge_small_piles(evidence: Evidence) -> Finding:
    conditions = {
        f"hand, {count}, {support}": spheres(0.06, support, HAND, count)
        for count in ROBOT_COUNTS
        for support in ("wall", "corner")
    }
    samples = evidence.samples_of(conditions)
    return Finding(tuple(judge_at_least(name, sample, 0.85) for name, sample in samples.items()), samples)


def _judge_pile_growth(evidence: Evidence) -> Finding:
    parts: list[Judgement] = []
    samples: dict[str, Sample] = {}
    for mass in COUNT_MASSES:
        small, large = (
            evidence.balanced_sample(spheres(mass, "none", SHOVEL, count) for count in counts)
            for counts in (SMALL_COUNTS, LARGE_COUNTS)
        )
        words = f"{1000 * mass:.0f} g"
        samples |= {f"{words}, 3 to 20 spheres": small, f"{words}, 60 and 90 spheres": large}
        part = judge_greater(f"{words}: 60 and 90 spheres", large, "3 to 20 spheres", small)
        parts.append(replace(part, calibrated=True))
    return Finding(tuple(parts), samples)


def _judge_masses(evidence: Evidence) -> Finding:
    parts: list[Judgement] = []
    samples: dict[str, Sample] = {}
    for support in ("wall", "corner"):
        light, heavy = (
            evidence.balanced_sample(spheres(m, support, SHOVEL) for m in masses)
            for masses in (LIGHT_MASSES, HEAVY_MASSES)
        )
        samples |= {f"{support}, 30 and 60 g": light, f"{support}, 360 and 720 g": heavy}
        parts.append(judge_greater(f"{support}: 30 and 60 g", light, "360 and 720 g", heavy))
    return Finding(tuple(parts), samples)


def _judge_pushes(evidence: Evidence) -> Finding:
    usual, harder = evidence.sample(USUAL_PUSH), evidence.sample(HARD_PUSH)
    part = judge_greater("0.25 m/s, 25 N", harder, "0.10 m/s, 17 N", usual, paired=True)
    return Finding((replace(part, calibrated=True),), {"0.10 m/s, 17 N": usual, "0.25 m/s, 25 N": harder})


def _judge_sizes(evidence: Evidence) -> Finding:
    samples = evidence.samples_of({f"ratio {ratio:g}": sized(ratio) for ratio in SIZE_RATIOS})
    first, *_, last = samples.values()
    grasped = [sample.mean_grasped for sample in samples.values()]
    correlation = _spearman(SIZE_RATIOS, tuple(grasped))
    reason = undecided_reason(*samples.values())
    found = "none, as it is the same everywhere" if correlation is None else f"{correlation:.2f}"
    falls = correlation is not None and correlation < MONOTONE
    parts = (
        Judgement(
            f"number grasped against ratio: Spearman {found}, below {MONOTONE} asked{reason}",
            "undecided" if reason else "holds" if falls else "fails",
        ),
        judge_below(f"success at ratio {SIZE_RATIOS[-1]:g}", last, 0.5),
        judge_greater(f"success at ratio {SIZE_RATIOS[0]:g}", first, f"at ratio {SIZE_RATIOS[-1]:g}", last),
    )
    numbers = {"ratio": list(SIZE_RATIOS), "mean_grasped": grasped, "spearman": correlation}
    return Finding(parts, samples, numbers)


@lru_cache(maxsize=10_000)
def _spearman(x: Sequence[float], y: Sequence[float]) -> float | None:
    """Return the rank correlation, or None if y is constant."""
    from scipy.stats import spearmanr

    return float(spearmanr(x, y).statistic) if len(set(y)) > 1 else None


CLAIMS = (
    Claim(
        "C6",
        "V-E, Fig. 10",
        "Without a support, 18 heavy spheres hardly ever trigger the grasp.",
        "0 of 10",
        "hand, no support, 18 heavy spheres: F_grasp is reached in at most 10 % of 50 pushes",
        _judge_unsupported,
        [UNSUPPORTED],
    ),
    Claim(
        "C7",
        "V-E, Fig. 10",
        "Beside a wall or in a corner, small piles suffice.",
        "more than 85 % already for 5 objects",
        "light spheres, hand: at least 85 % at 5 and at 18, wall and corner",
        _judge_small_piles,
        [spheres(0.06, support, HAND, 5) for support in ("wall", "corner")],
    ),
    Claim(
        "C8",
        "V-E, Fig. 10",
        "Without a support, success grows with the pile.",
        "success grows with the count; piles of 60 and more may do without a support",
        "no support, shovel, each of 60, 120 and 180 g: the rate at 60 and 90 objects above that at 3 to 20, "
        "calibrated by the felt's friction",
        _judge_pile_growth,
        [spheres(0.18, "none", SHOVEL, 90), spheres(0.06, "none", SHOVEL, 90)],
    ),
    Claim(
        "C9",
        "V-F, Fig. 11",
        "Lighter objects are easier to grasp where the pile is supported.",
        "lighter is easier; supports hinder heavy objects",
        "18 spheres, shovel: the rate at 30 and 60 g above that at 360 and 720 g, for wall and for corner",
        _judge_masses,
        [spheres(0.72, "corner", SHOVEL), spheres(0.72, "wall", SHOVEL)],
    ),
    Claim(
        "C10",
        "V-F",
        "Faster and harder pushes help with heavy objects in a corner.",
        "60 % to 85 %",
        "18 heavy spheres, corner, hand: 0.25 m/s and 25 N above 0.10 m/s and 17 N; calibrated by the fingertips",
        _judge_pushes,
        [USUAL_PUSH, HARD_PUSH],
    ),
    Claim(
        "C11",
        "V-D, Fig. 9",
        "Success and the number of objects depend on their size.",
        "both depend on the ratio of object and end-effector",
        "number grasped falls with the ratio (Spearman below -0.8); at the largest ratio success is below 50 % and "
        "below that at the smallest",
        _judge_sizes,
        [sized(SIZE_RATIOS[0]), sized(SIZE_RATIOS[-1])],
    ),
)
"""Claims C6 to C11, in the order of their names."""
