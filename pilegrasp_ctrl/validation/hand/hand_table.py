"""Everything that is measured of the RBO Hand 2 and the shovel, as one table and as checks."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from math import degrees

import numpy as np

from ...config import load_scenario
from ...episode import run
from ...recording import Recording
from ...sim.hand import Hand
from . import finger_measurements as finger
from . import holding
from .hand_bench import HandBench
from .measurement import Check, Measurement
from .sliding import hand_slide, shovel_slide

LOAD = 0.5
"""Of the fingertip [N]."""
PAYLOAD = 0.5
"""That the real hand is said to carry [kg] (Deimel and Brock, RSS 2014)."""
HEAVY_BALL = 0.180 * holding.GRAVITY
"""Weight of the heaviest ball of the paper's Table I [N]."""
OTHER_HANDS = "none found; other hands 4.0, 6.9 and 15.8 N (arXiv:2503.01585)"


def checks() -> list[Check]:
    """Return name, requested, measured, tolerance, unit and relation of every measurement; takes two attempts."""
    return [row.check() for row in measurements()]


def measurements() -> tuple[Measurement, ...]:
    """Measure both hands: the soft one on the bench and sliding, and the shovel sliding and scooping."""
    return (*bench_measurements(), *_sliding(), *_scooping())


def bench_measurements() -> tuple[Measurement, ...]:
    """Measure the RBO Hand 2 on the bench."""
    hand = Hand.load("rbo_hand2")
    return (*_fingers(hand), *_holding(hand))


def tip_stiffness(hand: Hand) -> float:
    """Return the tip stiffness of the straight middle finger by its equal springs, for small loads [N/m]."""
    length, levers = _geometry(hand)
    return float(hand.parameters["pneumatics"]["bending_stiffness"] / (length**2 * levers @ levers))


@cache
def attempt(hand: str, seed: int = 0) -> Recording:
    """Return the recording of an attempt of `spheres_wall`."""
    recording = run(load_scenario("spheres_wall", {"hand": hand}), seed=seed, record=True).recording
    assert recording is not None
    return recording


def _geometry(hand: Hand) -> tuple[float, np.ndarray]:
    """Return the length of the middle finger [m], and the levers of a force at its tip over that length."""
    shape = hand.parameters["fingers"]
    length = float(np.linalg.norm(np.subtract(shape["tip"][finger.FINGER], shape["base"][finger.FINGER])))
    return length, np.arange(1, shape["segments"] + 1) / shape["segments"]


def _fingers(hand: Hand) -> Iterator[Measurement]:
    bench, pneumatics = HandBench.build(hand), hand.parameters["pneumatics"]
    length, levers = _geometry(hand)
    stiffness = tip_stiffness(hand)
    yield Measurement(
        f"fingertip deflection under {LOAD:g} N, vented finger",
        *(1e3 * finger.deflection(bench, LOAD), "mm", 1e3 * LOAD / stiffness, 0.4, "="),
    )
    band = "none found; 5 to 50 N/m follow from the rubber"
    yield Measurement(
        "stiffness at the tip, vented", finger.stiffness(bench), "N/m", stiffness, 0.02 * stiffness, "=", band
    )
    yield Measurement(
        "stiffness at the tip, inflated", finger.stiffness(bench, 1.0), "N/m", stiffness, 0.0, ">=", "none found"
    )
    sideways = pneumatics["lateral_stiffness"] / length**2
    yield Measurement(
        "stiffness at the tip, sideways", finger.lateral_stiffness(bench), "N/m", sideways, 0.06 * sideways, "="
    )
    bend = degrees(levers.size * pneumatics["closing_moment"] / pneumatics["bending_stiffness"])
    yield Measurement(
        "bend of the closed finger in free space", degrees(finger.free_bend(bench)), "deg", bend, 1.0, "="
    )
    waits = "the lab waits 1 to 5 s for it (ec_grasp_planner)"
    allowed = hand.parameters["use"]["closing_time"]
    yield Measurement(
        "closing time, to 90 % of the tip's way", finger.closing_time(bench), "s", allowed, 0.0, "<=", waits
    )
    # The deflections by the moment and by the force cancel.
    force = pneumatics["closing_moment"] / length * levers.sum() / (levers @ levers)
    yield Measurement(
        "fingertip force, finger blocked straight", finger.blocked_force(bench), "N", force, 0.06 * force, "="
    )


def _holding(hand: Hand) -> Iterator[Measurement]:
    for direction in holding.PULLS:
        pull = holding.pull_out_force(hand, direction)
        yield Measurement(f"pull-out of a 54 mm ball, {direction}", pull, "N", HEAVY_BALL, 0.0, ">=", OTHER_HANDS)
    slip = 1e3 * holding.slip(hand, PAYLOAD)
    yield Measurement(f"slip of a {PAYLOAD:g} kg ball in lift and hold", slip, "mm", 1e3 * holding.LOST, 0.0, "<=")
    carried = "about 0.5 kg (Deimel and Brock, RSS 2014, as remembered)"
    yield Measurement("payload, lift and hold", holding.payload(hand), "kg", PAYLOAD, 0.0, ">=", carried)


def _sliding() -> Iterator[Measurement]:
    hand = Hand.load("rbo_hand2")
    slide = hand_slide(attempt("rbo_hand2"), hand)
    preshaped = degrees(finger.free_bend(HandBench.build(hand), hand.parameters["use"]["preshape"]))
    yield Measurement("palm above the table in the push, least", 1e3 * slide.palm_clearance, "mm", 0.0, 0.0, ">=")
    yield Measurement("sensor above the table in the push, least", 1e3 * slide.sensor_clearance, "mm", 0.0, 0.0, ">=")
    yield Measurement("bend of the sliding fingers", degrees(slide.alone), "deg", preshaped, 0.0, ">=")
    flatter = degrees(hand.theta)
    yield Measurement("slope of the sliding fingertips", degrees(slide.tip_slope), "deg", flatter, 0.0, "<=")
    yield Measurement("table on the sliding hand", slide.table_force, "N", 5.0, 0.0, "<=")


def _scooping() -> Iterator[Measurement]:
    hand = Hand.load("shovel")
    slide = shovel_slide(attempt("shovel"), hand)
    wanted, edge = hand.parameters["use"]["normal_force"], 1e3 * slide.edge_height
    code = "5 N desired (ec_grasp_planner)"
    yield Measurement("shovel: table force while sliding, mean", slide.table_force, "N", wanted, 1.0, "=", code)
    yield Measurement("shovel: table force while sliding, peak", slide.peak_table_force, "N", 2.0 * wanted, 0.0, "<=")
    yield Measurement("shovel: leading edge above the table, most", edge, "mm", 0.0, 1.0, "=")
    yield Measurement(
        "shovel: slope of the floor in the push", degrees(slide.slope), "deg", degrees(hand.theta), 1.0, "="
    )
    tilt = "18° in the lift (ec_grasp_planner)"
    angle = degrees(hand.use.scoop_angle)
    yield Measurement("shovel: tilt back in the scoop", degrees(slide.scoop_angle), "deg", angle, 2.0, "=", tilt)
