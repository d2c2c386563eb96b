"""Null models N1 to N4: what is left without a pile, without fingers, without contacts, and what decides unseen."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from pilegrasp_ctrl.scenarios.paper.comparisons import p_mcnemar
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence, Sample, pairs
from pilegrasp_ctrl.scenarios.paper.figures_mechanism import FLAT, PUSHED
from pilegrasp_ctrl.scenarios.paper.figures_nulls import (
    AIM_ERRORS,
    FEW_BALLS,
    LOOSE,
    SWAPPED,
    TIP_RADII,
    TIPS,
    WORLDS,
    few,
)
from pilegrasp_ctrl.scenarios.paper.judgement import (
    Claim,
    Finding,
    Judgement,
    Significance,
    format_rate,
    format_share,
    judge_greater,
    undecided_reason,
)


def _judge_few(evidence: Evidence) -> Finding:
    parts = []
    for support in ("wall", "corner"):
        one, more = (evidence.balanced_sample(few(count, support, error) for error in AIM_ERRORS) for count in (1, 5))
        part = judge_greater(f"{support}, all errors of the aim: five balls", more, "one ball", one)
        parts.append(replace(part, reported=True))
    return Finding(tuple(parts), evidence.samples_of(FEW_BALLS))


def _judge_plate(evidence: Evidence) -> Finding:
    parts: list[Judgement] = []
    samples: dict[str, Sample] = {}
    for support, swapped in SWAPPED.items():
        hand, taken = evidence.sample(PUSHED[support]), evidence.sample(swapped)
        samples |= {f"hand pushes, {support}": hand, f"plate pushes, {support}": taken}
        parts.append(judge_greater(f"{support}: hand pushes", hand, "plate pushes", taken, paired=True))
    for support in SWAPPED:
        hand, plate = evidence.sample(PUSHED[support]), evidence.sample(FLAT[support])
        samples[f"plate alone, {support}"] = plate
        parts.append(_separation(support, hand, plate))
    return Finding(tuple(parts), samples)


def _separation(support: str, hand: Sample, plate: Sample) -> Judgement:
    """Judge whether the hand separates an object more often than the plate before the same piles."""
    count, other = hand.count("separated"), plate.count("separated")
    text = (
        f"{support}: one object at rest at the hand in {format_share(count, hand.n)}, at the plate in "
        f"{format_share(other, plate.n)}"
    )
    if reason := undecided_reason(hand, plate):
        return Judgement(text + reason, "undecided")
    _, only, rest, _ = pairs(hand, plate, "separated")
    return Judgement(text, None, Significance(p_mcnemar(only, rest), p_mcnemar(rest, only)))


def _judge_loose(evidence: Evidence) -> Finding:
    parts: list[Judgement] = []
    samples: dict[str, Sample] = {}
    for name, (whole, loose) in LOOSE.items():
        with_forces, without = evidence.sample(whole), evidence.sample(loose)
        samples |= {name: with_forces, f"{name}, loose": without}
        held = f"held {format_rate(with_forces)}, without contacts {format_rate(without)}"
        reached = [format_share(sample.count("triggered"), sample.n) for sample in (with_forces, without)]
        parts.append(Judgement(f"{name}: {held}; F_grasp {reached[0]}, without {reached[1]}", reported=True))
    return Finding(tuple(parts), samples)


def _judge_axes(evidence: Evidence) -> Finding:
    samples = evidence.samples_of(TIPS | WORLDS)
    parts = [Judgement(f"{name}: {format_rate(sample)}", reported=True) for name, sample in samples.items()]
    return Finding((_both_hold(samples), *parts), samples)


def _both_hold(samples: Mapping[str, Sample]) -> Judgement:
    """Report the radii of the fingertips at which cylinders are held in 95 %, and C10's second push is better."""
    found = []
    for radius in TIP_RADII:
        usual, harder, cylinders = (
            samples[f"{words}, tips of {1000 * radius:g} mm"]
            for words in ("heavy, corner, 17 N", "heavy, corner, 25 N", "cylinders, wall")
        )
        if cylinders.n and cylinders.rate >= 0.95 and harder.rate > usual.rate:
            found.append(f"{1000 * radius:g} mm")
    where = f"at {', '.join(found)}" if found else "at none of the radii"
    return Judgement(f"cylinders in 95 % and a gain by the harder push (estimates): {where}", reported=True)


NULLS = (
    Claim(
        "N1",
        "null model",
        "One ball and a few balls, without a pile.",
        "-",
        "reported: 1, 2, 3 and 5 balls, hand, wall and corner, aim off by 0, 20 and 40 mm to either side",
        _judge_few,
        [few(1, "wall", 0.0)],
    ),
    Claim(
        "N2",
        "null model",
        "A flat plate pushes, and the hand closes where the plate stopped.",
        "-",
        "success and separation are below the hand's, before the same piles",
        _judge_plate,
        list(SWAPPED.values()),
    ),
    Claim(
        "N3",
        "null model",
        "The objects of the pile do not touch one another.",
        "-",
        "reported beside C6 to C8: what the forces between objects add",
        _judge_loose,
        [loose for _, loose in LOOSE.values()],
    ),
    Claim(
        "N4",
        "null model",
        "Numbers without a source, other piles, and what the arm does not know.",
        "C10: 60 to 85 %; C1: 95 to 100 %",
        "reported: is there a radius of the fingertips at which C1 and C10 both hold?",
        _judge_axes,
        list(TIPS.values()),
    ),
)
"""The null models, in the order of their names."""
