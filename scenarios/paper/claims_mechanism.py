"""Claims C12 to C16: the mechanism of a grasp, and its use for orders."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np

from pilegrasp_ctrl.scenarios.paper.comparisons import p_mcnemar
from pilegrasp_ctrl.scenarios.paper.conditions import HAND, HAND_NAMES, OBJECT_NAMES, SHOVEL, SUPPORTS, grasp
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence, Sample, differences
from pilegrasp_ctrl.scenarios.paper.figures_mechanism import (
    FLAT,
    NOISY,
    OPERATORS,
    ORDER_NAMES,
    PAPER_ATTEMPTS,
    PUSHED,
    order_condition,
)
from pilegrasp_ctrl.scenarios.paper.figures_objects import with_other_controller
from pilegrasp_ctrl.scenarios.paper.judgement import (
    MIN_ATTEMPTS,
    Claim,
    Finding,
    Judgement,
    Significance,
    format_percent,
    format_share,
    judge,
    undecided_reason,
)
from pilegrasp_ctrl.types import Array

FORESEEN = {
    f"hand, {OBJECT_NAMES[name]}, {support}": grasp(name, support)
    for name, support in (
        ("light_sphere", "none"),
        *product(("light_sphere", "heavy_sphere", "cylinder"), ("wall", "corner")),
        ("cube", "wall"),
    )
}
"""Conditions at which the rule that names the held object stands beside its chance level, by name (C13)."""
SEVERAL = (0.05, 0.30)
"""Smallest and largest share of successes with several objects for which C12 holds; claims, C12."""
PRESSES = 3.0
"""Smallest ratio of table forces for which C15 holds; claims, C15."""
MIN_SEPARATED = 0.5
"""Smallest share of the hand's successes in which one object was separated and at rest; claims, C13."""
MAX_R = 5.0
"""Largest mean number of attempts for an order of light spheres; claims, C14."""


def _judge_several(evidence: Evidence) -> Finding:
    hand, shovel = evidence.grasps_with(HAND), evidence.grasps_with(SHOVEL)
    numbers, texts = {}, []
    for word, sample in zip(HAND_NAMES.values(), (hand, shovel), strict=True):
        several, successes = sample.count("several"), sample.successes
        numbers[word] = {"multiple": several, "successes": successes, "share": several / max(1, successes)}
        texts.append(f"{word}: more than one object in {format_share(several, successes)}")
    least, most = SEVERAL
    text = f"{texts[0]}, {100 * least:.0f} to {format_percent(most)} asked"
    if hand.successes < MIN_ATTEMPTS:
        part = Judgement(f"{text}; too few successes", "undecided")
    else:
        part = Judgement(text, "holds" if least <= numbers["hand"]["share"] <= most else "fails")
    fitted = Judgement(texts[1], reported=True)
    return Finding((part, fitted), {"hand, all": hand, "shovel, all": shovel}, numbers)


def _judge_motion(evidence: Evidence) -> Finding:
    samples = evidence.samples_of({f"hand, {support}": PUSHED[support] for support in SUPPORTS})
    plates = evidence.samples_of({f"plate, {support}": FLAT[support] for support in SUPPORTS})
    parts = []
    for support in SUPPORTS:
        hand, plate = samples[f"hand, {support}"], plates[f"plate, {support}"]
        text = f"{support}: objects come nearer to the hand{_speed(hand, 'approach speed')} faster than to a flat plate"
        text += _speed(plate, "approach speed")
        parts.append(_signs(text, differences(hand, plate, "approach speed"), hand, plate))
    for support in SUPPORTS:
        hand = samples[f"hand, {support}"]
        text = f"{support}: objects beside the hand move away from it{_speed(hand, 'spread speed')}"
        parts.append(_signs(text, hand.numbers("spread speed"), hand))
    none, wall = samples["hand, none"], samples["hand, wall"]
    parts.append(_signs("a wall narrows the spread", differences(none, wall, "spread speed"), none, wall))
    successes = evidence.grasps_with(HAND)
    held = successes.flags("success")
    separated = int(np.count_nonzero(held & successes.flags("separated")))
    asked = int(np.count_nonzero(held))
    text = (
        "hand: at the trigger exactly one object is at the hand, at rest for 0.1 s, in "
        f"{format_share(separated, asked)} successes, {format_percent(MIN_SEPARATED)} asked"
    )
    if asked < MIN_ATTEMPTS:
        parts.append(Judgement(f"{text}; too few successes", "undecided"))
    else:
        parts.append(Judgement(text, "holds" if separated >= MIN_SEPARATED * asked else "fails"))
    numbers: dict[str, Any] = {"separated": {"n": asked, "count": separated}}
    every = {f"{word}, all": evidence.grasps_with(end_effector) for end_effector, word in HAND_NAMES.items()}
    every |= evidence.samples_of(FORESEEN)
    for name, sample in every.items():
        n, foreseen, chance = sample.count("asked"), sample.count("foreseen"), sample.mean("chance")
        numbers[name] = {"n": n, "foreseen": foreseen, "chance": chance}
        beside = "" if chance is None else f"; drawn from those at the hand {format_percent(chance)}"
        text = f"{name}: the rule names the held object before the trigger in {format_share(foreseen, n)}{beside}"
        parts.append(Judgement(text, reported=True))
    return Finding(tuple(parts), samples | plates, numbers)


def _speed(sample: Sample, name: str) -> str:
    mean = sample.mean(name)
    return "" if mean is None else f" ({1000 * mean:.0f} mm/s)"


def _signs(text: str, values: Array, *samples: Sample) -> Judgement:
    """Judge by the sign test whether values lie above 0."""
    above, below = int(np.count_nonzero(values > 0.0)), int(np.count_nonzero(values < 0.0))
    text = f"{text}: {above} to {below}"
    if reason := undecided_reason(*samples) or (
        f"; measured in {values.size} attempts only" if values.size < MIN_ATTEMPTS else ""
    ):
        return Judgement(text + reason, "undecided")
    return Judgement(text, None, Significance(p_mcnemar(above, below), p_mcnemar(below, above)))


def _judge_orders(evidence: Evidence) -> Finding:
    parts: list[Judgement] = []
    samples: dict[str, Sample] = {}
    numbers: dict[str, Any] = {"paper": PAPER_ATTEMPTS}
    for place, operator in enumerate(OPERATORS):
        here = evidence.samples_of({name: order_condition(kind, operator) for kind, name in ORDER_NAMES.items()})
        found, mean = _judge_operator(here, operator)
        parts += found if place == 0 else [replace(part, reported=True) for part in found]
        samples |= {f"{name}, operator {operator}": sample for name, sample in here.items()}
        numbers[operator] = {"R": mean}
    numbers["R"] = numbers[OPERATORS[0]]["R"]
    return Finding(tuple(parts), samples, numbers)


def _judge_operator(samples: dict[str, Sample], operator: str) -> tuple[list[Judgement], dict[str, float]]:
    """Return the statements about one operator, and the mean number of attempts by kind of object."""
    means = {name: sample.mean("order attempts") for name, sample in samples.items()}
    mean = {name: found for name, found in means.items() if found is not None}
    everything = Sample.pooled(samples.values())
    head = f"operator that {operator}: "
    text = f"{head}{everything.successes} of {everything.n} orders complete, all asked"
    parts = [judge(text, everything.successes == everything.n, *samples.values())]
    light, heavy, cylinder = (mean.get(ORDER_NAMES[name]) for name in ("light_sphere", "heavy_sphere", "cylinder"))
    if light is None or heavy is None or cylinder is None or len(mean) < len(samples):
        parts.append(Judgement(f"{head}attempts for an order: not run for every kind of object", "undecided"))
        return parts, mean
    for text, holds in (
        (f"{head}light spheres: R = {light:.1f}, at most 5 asked", light <= MAX_R),
        (f"{head}light spheres: R = {light:.1f}, at most that of heavy ones, {heavy:.1f}", light <= heavy),
        (f"{head}cylinders: R = {cylinder:.1f}, the largest asked", cylinder >= max(mean.values())),
    ):
        parts.append(judge(text, holds, *samples.values()))
    return parts, mean


def _judge_table_force(evidence: Evidence) -> Finding:
    conditions = {
        "hand, operational space": grasp("light_sphere", "wall", HAND),
        "hand, impedance": with_other_controller(HAND),
        "shovel, impedance": grasp("light_sphere", "wall", SHOVEL),
        "shovel, operational space": with_other_controller(SHOVEL),
    }
    samples = evidence.samples_of(conditions)
    means = {name: sample.mean("table force") for name, sample in samples.items()}
    mean = {name: found for name, found in means.items() if found is not None}
    if len(mean) < len(samples):
        return Finding((Judgement("the force of the table was not measured everywhere", "undecided"),), samples)
    stiff, yielding = mean["shovel, operational space"], mean["shovel, impedance"]
    soft = mean["hand, operational space"]
    parts = (
        judge(
            f"shovel: peak force of the table {stiff:.1f} N under operational-space control, more than {PRESSES:g} "
            f"times the {yielding:.1f} N under impedance control asked",
            stiff > PRESSES * yielding,
            *samples.values(),
        ),
        judge(
            f"hand under operational-space control: {soft:.1f} N, less than {PRESSES:g} times the {yielding:.1f} N of "
            "the yielding shovel asked",
            soft < PRESSES * yielding,
            *samples.values(),
        ),
    )
    return Finding(parts, samples, {"mean_peak_force": mean})


def _judge_events(evidence: Evidence) -> Finding:
    samples = {"all": evidence.grasps_with(HAND, SHOVEL), "noisy sensor": evidence.sample(*NOISY)}
    parts = []
    for name, sample in samples.items():
        successes = sample.successes
        astray = sample.count("astray")
        text = (
            f"{name}: {successes - astray} of {successes} successful attempts show touch-down and F_grasp in order, "
            "all asked"
        )
        if successes < MIN_ATTEMPTS:
            parts.append(Judgement(f"{text}; too few successes", "undecided"))
        else:
            parts.append(Judgement(text, "holds" if astray == 0 else "fails"))
    return Finding(tuple(parts), samples, remark="The closing of the hand is a timer, no contact event.")


CLAIMS = (
    Claim(
        "C12",
        "V-D",
        "Some grasps hold more than one object.",
        "15 % of 600 (hand), 8.75 % of 160 (shovel)",
        "over all successful attempts of the hand: between 5 and 30 %; the shovel is reported beside it",
        _judge_several,
        [grasp("light_sphere")],
    ),
    Claim(
        "C13",
        "III, Fig. 2",
        "Objects in front of the hand approach it, the others spread; one separates and comes to rest.",
        "a sketch",
        "objects approach the hand faster than a flat plate that pushes the same pile; spread outside above 0, and "
        "less beside a wall; in at least 50 % of the hand's successes exactly one object is at the hand at the "
        "trigger, at rest for 0.1 s; the rule that names the held object stands beside its chance level, by condition",
        _judge_motion,
        [PUSHED["wall"]],
    ),
    Claim(
        "C14",
        "V-H, Table I",
        "Orders of four are picked from a bin tilted by 5 degrees.",
        "R = 4.3, 5, 9, 5.6, 7.6 attempts for light and heavy spheres, cylinders, limes and apples",
        "operator that knows the bin's pose and the wrist sensor alone: every order completes, R(light) <= 5, "
        "R(light) <= R(heavy), R(cylinder) is the largest; the operator that sees every pose stands beside it",
        _judge_orders,
        [order_condition(object_model, OPERATORS[0]) for object_model in ORDER_NAMES],
    ),
    Claim(
        "C15",
        "V-D",
        "The rigid shovel needs force control to slide safely, the soft hand does not.",
        "impedance control for the shovel, operational-space control for the hand",
        "the shovel's table force under operational-space control is more than 3 times that under impedance control; "
        "the hand's under operational-space control is not",
        _judge_table_force,
        [with_other_controller(SHOVEL), grasp("light_sphere", "wall", SHOVEL)],
    ),
    Claim(
        "C16",
        "IV",
        "The transitions between the primitives are contact events.",
        "normal force at touch-down, F_grasp along the push, then the hand closes",
        "every successful attempt shows touch-down and F_grasp in order, from the wrist sensor alone; so do 200 "
        "attempts with three times its noise and 1 N of slow drift",
        _judge_events,
        [grasp("light_sphere")],
    ),
)
"""Claims C12 to C16, in the order of their names."""
