"""Claims C12 to C16: the mechanism of a grasp, and its use for orders."""

from __future__ import annotations

from collections.abc import Mapping
from statistics import fmean
from typing import Any

from pilegrasp_ctrl.scenarios.paper.conditions import HAND, HAND_NAMES, SHOVEL, grasp
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence, Sample
from pilegrasp_ctrl.scenarios.paper.figures_mechanism import (
    ORDER_NAMES,
    PAPER_ATTEMPTS,
    PUSHED,
    attempts_per_order,
    order_condition,
)
from pilegrasp_ctrl.scenarios.paper.figures_objects import with_other_controller
from pilegrasp_ctrl.scenarios.paper.judgement import (
    MIN_ATTEMPTS,
    Claim,
    Finding,
    Judgement,
    Verdict,
    format_percent,
    judge,
    undecided_reason,
)
from pilegrasp_ctrl.scenarios.paper.motion_verdict import MIN_KNOWN_SHARE, motion_verdict
from pilegrasp_ctrl.statistics import wilson

SEVERAL = (0.05, 0.30)
"""Smallest and largest share of successes with several objects for which C12 holds; chosen around the paper's."""
PRESSES = 3.0
"""Smallest ratio of table forces for which C15 holds; chosen."""
EVENTS = (("approach", ("surface contact",)), ("push", ("grasp force",)), ("grasp", ("closed", "tilted back")))
"""The three primitives of the paper (IV) and the events that end them; the shovel closes by tilting back."""
ORDERS = 3
"""Number of orders for each object model in the paper, and smallest number that decides."""


def _judge_several(evidence: Evidence) -> Finding:
    hand, shovel = evidence.grasps_with(HAND), evidence.grasps_with(SHOVEL)
    numbers, texts = {}, []
    for word, sample in zip(HAND_NAMES.values(), (hand, shovel), strict=True):
        low, high = wilson(sample.multiple, sample.successes)
        share = sample.multiple / sample.successes if sample.successes else 0.0
        numbers[word] = {"multiple": sample.multiple, "successes": sample.successes, "share": share}
        texts.append(f"{100 * share:.1f} % of {sample.successes} successes ({100 * low:.0f} to {format_percent(high)})")
    least, most = SEVERAL
    enough = hand.successes >= MIN_ATTEMPTS
    text = f"hand: more than one object in {texts[0]}, {100 * least:.0f} to {format_percent(most)} asked"
    verdict: Verdict = ("holds" if least <= numbers["hand"]["share"] <= most else "fails") if enough else "not decided"
    part = Judgement(text if enough else f"{text}; too few successes", verdict)
    return Finding((part,), {"hand, all": hand, "shovel, all": shovel}, numbers, f"Shovel: {texts[1]}.")


def _judge_motion(evidence: Evidence) -> Finding:
    samples = evidence.samples_of(PUSHED)
    answers = motion_verdict({name: sample.measures("motion") for name, sample in samples.items()})
    reason = undecided_reason(*samples.values())
    parts: list[Judgement] = []
    numbers: dict[str, Any] = {"Fig. 2": answers}
    for key, measure, words in (
        ("approach", "approach_speed", "objects before the hand come nearer to it"),
        ("spread", "spread_speed", "the others move away from it"),
    ):
        found = (sample.measures("motion", measure) for sample in evidence.grasp_samples(HAND, SHOVEL))
        means = [fmean(values) for values in found if values]
        positive = sum(mean > 0.0 for mean in means)
        text = f"{words}: on average at {positive} of {len(means)} conditions, all asked"
        verdict: Verdict = "fails" if positive < len(means) else answers[key]["verdict"]
        parts.append(Judgement(f"{text}; at those of Fig. 2 {_p_text(answers[key])}{reason}", verdict))
        numbers[key] = {"conditions": len(means), "positive": positive}
    parts.append(
        Judgement(f"a wall narrows the spread: {_p_text(answers['wall'])}{reason}", answers["wall"]["verdict"])
    )
    for hand, word in HAND_NAMES.items():
        agreed = evidence.grasps_with(hand).measures("motion", "agreed")
        part, numbers[word] = _judge_separation(word, agreed)
        parts.append(part)
    if reason:
        parts = [Judgement(part.statement, "not decided") for part in parts]
    fig2 = answers["separation"]
    remark = f"At the conditions of Fig. 2 the object was known in {fig2['agreed']} of {fig2['n']} successes."
    return Finding(tuple(parts), samples, numbers, remark)


def _judge_separation(word: str, agreed: list[bool]) -> tuple[Judgement, dict[str, Any]]:
    low, high = wilson(sum(agreed), len(agreed))
    share = sum(agreed) / len(agreed) if agreed else 0.0
    text = (
        f"{word}: the object that is held later is known before the trigger in {sum(agreed)} of {len(agreed)} "
        f"successes ({100 * low:.0f} to {format_percent(high)}), {format_percent(MIN_KNOWN_SHARE)} asked"
    )
    numbers = {"n": len(agreed), "agreed": sum(agreed), "rate": share, "ci_low": low, "ci_high": high}
    if len(agreed) < MIN_ATTEMPTS:
        return Judgement(f"{text}; too few", "not decided"), numbers
    return Judgement(text, "holds" if share >= MIN_KNOWN_SHARE else "fails"), numbers


def _p_text(answer: Mapping[str, Any]) -> str:
    return "not measured" if answer["p"] is None else f"p = {answer['p']:.2g}"


def _judge_orders(evidence: Evidence) -> Finding:
    samples = evidence.samples_of({name: order_condition(object_model) for object_model, name in ORDER_NAMES.items()})
    needed = {name: attempts_per_order(sample) for name, sample in samples.items()}
    mean = {name: fmean(found) for name, found in needed.items() if found}
    everything = Sample.pooled(samples.values())
    complete = f"{everything.successes} of {everything.n} orders complete, all asked"
    parts = [judge(complete, everything.successes == everything.n, *samples.values(), enough=ORDERS)]
    light, heavy, cylinder = (mean.get(ORDER_NAMES[name]) for name in ("light_sphere", "heavy_sphere", "cylinder"))
    if light is None or heavy is None or cylinder is None or len(mean) < len(samples):
        parts.append(Judgement("attempts for an order: not run for every kind of object", "not decided"))
    else:
        for text, holds in (
            (f"light spheres: R = {light:.1f}, at most 5 asked", light <= 5.0),
            (f"light spheres: R = {light:.1f}, at most that of heavy ones, {heavy:.1f}", light <= heavy),
            (f"cylinders: R = {cylinder:.1f}, the largest asked", cylinder >= max(mean.values())),
        ):
            parts.append(judge(text, holds, *samples.values(), enough=ORDERS))
    return Finding(tuple(parts), samples, {"R": mean, "paper": PAPER_ATTEMPTS})


def _judge_table_force(evidence: Evidence) -> Finding:
    conditions = {
        "hand, operational space": grasp("light_sphere", "wall", HAND),
        "hand, impedance": with_other_controller(HAND),
        "shovel, impedance": grasp("light_sphere", "wall", SHOVEL),
        "shovel, operational space": with_other_controller(SHOVEL),
    }
    samples = evidence.samples_of(conditions)
    force = {name: sample.measures("table_force", "peak") for name, sample in samples.items()}
    mean = {name: fmean(found) for name, found in force.items() if found}
    if len(mean) < len(force):
        return Finding((Judgement("the force of the table was not measured everywhere", "not decided"),), samples)
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
    grasps = evidence.grasps_with(HAND, SHOVEL)
    successes = [row.result for row in grasps.rows if row.success and row.result is not None]
    ordered = sum(shows_events(result) for result in successes)
    text = f"{ordered} of {len(successes)} successful attempts show touch-down, F_grasp and closing in order, all asked"
    if len(successes) < MIN_ATTEMPTS:
        return Finding((Judgement(f"{text}; too few successes", "not decided"),), {"all": grasps})
    return Finding((Judgement(text, "holds" if ordered == len(successes) else "fails"),), {"all": grasps})


def shows_events(result: Mapping[str, Any]) -> bool:
    """Return whether the three primitives ended by their contact events, each after the one before."""
    outcomes = result["outcomes"][: len(EVENTS)]
    if len(outcomes) < len(EVENTS):
        return False
    named_right = all(
        outcome["name"] == name and outcome["trigger"] in triggers
        for outcome, (name, triggers) in zip(outcomes, EVENTS, strict=True)
    )
    times = [time for outcome in outcomes for time in (outcome["start"], outcome["end"])]
    return named_right and times == sorted(times)


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
        "at every condition, mean approach speed above 0 inside the funnel and radial spread above 0 outside; wall "
        "below none for the spread; for hand and for shovel, the separated object is known before the trigger in at "
        "least 90 % of the successes",
        _judge_motion,
        list(PUSHED.values())[1:],
    ),
    Claim(
        "C14",
        "V-H, Table I",
        "Orders of four are picked from a bin tilted by 5 degrees.",
        "R = 4.3, 5, 9, 5.6, 7.6 attempts for light and heavy spheres, cylinders, limes and apples",
        "every order completes; R(light) <= 5, R(light) <= R(heavy), R(cylinder) is the largest",
        _judge_orders,
        [order_condition(object_model) for object_model in ORDER_NAMES],
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
        "every successful attempt shows the three events in order, from the wrist sensor alone",
        _judge_events,
        [grasp("light_sphere")],
    ),
)
"""Claims C12 to C16, in the order of their names."""
