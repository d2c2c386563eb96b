"""Every measurement of the RBO Hand 2 and the shovel, as checks and as the table of the page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from math import degrees

import numpy as np

from ...config import load_scenario
from ...episode import run
from ...exceptions import RecordingError
from ...recording import Recording
from ...sim.hand import Hand
from ...sim.pad import PAD_LOAD
from ...statistics import markdown_table
from ..physics.contact_rig import GRAVITY
from ..physics.physics_check import PhysicsCheck, Relation
from . import hand_bench, holding
from .hand_bench import HandBench
from .sliding import hand_slide, shovel_slide
from .squeeze import meeting_slope, thickness

LOAD = 0.5
"""Load of the fingertip [N]; chosen."""

SQUEEZES = (0.0, 2.0, PAD_LOAD)
"""Loads that flatten the fingertip [N]; chosen."""

RADII = {"ball": 0.027, "cylinder": 0.020}
"""Radii of what the fingertip has to slide under [m]; `scenarios/objects`."""

SIDE_LOAD = 8.0
"""Load that pushes a finger against its neighbour [N]; chosen above what carries it there."""

PAYLOAD = 0.5
"""Published payload of the real hand [kg] (Deimel and Brock, RSS 2014)."""

HEAVY_BALL = 0.180 * GRAVITY
"""Weight of the heaviest ball of the paper's Table I [N]."""

OTHER_HANDS = "none found; other hands 4.0, 6.9 and 15.8 N (arXiv:2503.01585)"
"""Published pull-out forces."""


def measurements() -> tuple[PhysicsCheck, ...]:
    """Measure both hands: the soft one on the bench and sliding, the shovel sliding and scooping."""
    hand = Hand.load("rbo_hand2")
    return (*_fingers(hand), *_tip(hand), *_holding(hand), *_sliding(), *_scooping())


def markdown(checks: Sequence[PhysicsCheck]) -> str:
    """Return measured, requested and published numbers as a Markdown table."""
    rows = []
    for check in checks:
        sign = {"=": "", "<=": "≤ ", ">=": "≥ "}[check.relation]
        margin = f" ± {check.tolerance:.3g}" if check.relation == "=" else ""
        requested = f"{sign}{check.requested:.3g}{margin}"
        measured = f"{check.measured:.3g} {check.unit}"
        rows.append((check.name, measured, requested, check.published or "none found"))
    return markdown_table(("", "measured", "should be", "published"), rows)


def tip_stiffness(hand: Hand) -> float:
    """Return the tip stiffness of the straight middle finger for small loads, from its equal springs [N/m]."""
    length, levers = _geometry(hand)
    return float(hand.parameters["pneumatics"]["bending_stiffness"] / (length**2 * levers @ levers))


@cache
def recorded_attempt(hand: str, seed: int = 0) -> Recording:
    """Return the recording of an attempt of `spheres_wall`.

    Raises:
        RecordingError: The attempt left no recording.
    """
    recording = run(load_scenario("spheres_wall", {"hand": hand}), seed=seed, record=True).recording
    if recording is None:
        raise RecordingError(f"the attempt with hand {hand} left no recording")
    return recording


def _geometry(hand: Hand) -> tuple[float, np.ndarray]:
    """Return the length of the middle finger [m], and the levers of a force at its tip over that length."""
    shape = hand.parameters["fingers"]
    length = float(np.linalg.norm(np.subtract(shape["tip"][hand_bench.FINGER], shape["base"][hand_bench.FINGER])))
    return length, np.arange(1, shape["segments"] + 1) / shape["segments"]


def _check(
    name: str, measured: float, unit: str, requested: float, tolerance: float, relation: Relation, published: str = ""
) -> PhysicsCheck:
    return PhysicsCheck(name, requested, measured, tolerance, unit, relation, published=published)


def _fingers(hand: Hand) -> Iterator[PhysicsCheck]:
    bench, pneumatics = HandBench.build(hand), hand.parameters["pneumatics"]
    length, levers = _geometry(hand)
    stiffness = tip_stiffness(hand)
    deflection = 1e3 * hand_bench.deflection(bench, LOAD)
    yield _check(
        f"fingertip deflection under {LOAD:g} N, vented finger", deflection, "mm", 1e3 * LOAD / stiffness, 0.4, "="
    )
    vented, inflated = hand_bench.stiffness(bench), hand_bench.stiffness(bench, 1.0)
    band = "none found; 5 to 50 N/m follow from the rubber"
    yield _check("stiffness at the tip, vented", vented, "N/m", stiffness, 0.02 * stiffness, "=", band)
    yield _check("stiffness at the tip, inflated", inflated, "N/m", stiffness, 0.0, ">=")
    sideways = pneumatics["lateral_stiffness"] / length**2
    lateral = hand_bench.lateral_stiffness(bench)
    yield _check("stiffness at the tip, sideways", lateral, "N/m", sideways, 0.06 * sideways, "=")
    bend = degrees(levers.size * pneumatics["closing_moment"] / pneumatics["bending_stiffness"])
    turned = degrees(hand_bench.free_bend(bench))
    yield _check("bend of the closed finger in free space", turned, "deg", bend, 1.0, "=")
    waits = "the lab waits 1 to 5 s for it (ec_grasp_planner)"
    time, allowed = hand_bench.closing_time(bench), hand.parameters["use"]["closing_time"]
    yield _check("closing time, to 90 % of the tip's way", time, "s", allowed, 0.0, "<=", waits)
    # The deflections by the moment and by the force cancel.
    force = pneumatics["closing_moment"] / length * levers.sum() / (levers @ levers)
    blocked = hand_bench.blocked_force(bench)
    yield _check("fingertip force, finger blocked straight", blocked, "N", force, 0.06 * force, "=")


def _tip(hand: Hand) -> Iterator[PhysicsCheck]:
    """Check the thickness of a fingertip under load, and the slope at which it then meets what lies on the table."""
    free, give = 2e3 * hand.parameters["fingers"]["radius_tip"], 1e3 * hand.parameters["pad"]["give"]
    boxes = "boxes of 20 mm (lab model)"
    for load in SQUEEZES:
        measured = 1e3 * thickness(hand, load)
        name = f"thickness of the fingertip under {load:g} N"
        if 0.0 < load < PAD_LOAD:
            yield _check(name, measured, "mm", free, 0.0, "<=")
        else:
            flat = 2.0 * give if load else 0.0
            yield _check(name, measured, "mm", free - flat, 0.2, "=", "" if load else boxes)
        for what, radius in RADII.items():
            slope = degrees(meeting_slope(1e-3 * measured, radius))
            yield _check(f"slope at which it then meets a lying {what}, {load:g} N", slope, "deg", 0.0, 0.0, ">=")
    depth = 1e3 * hand_bench.touch_depth(HandBench.build(hand), SIDE_LOAD)
    yield _check(f"overlap of a finger that {SIDE_LOAD:g} N push on its neighbour", depth, "mm", 0.5 * free, 0.0, "<=")


def _holding(hand: Hand) -> Iterator[PhysicsCheck]:
    for direction in holding.PULLS:
        pull = holding.pull_out_force(hand, direction)
        yield _check(f"pull-out of a 54 mm ball, {direction}", pull, "N", HEAVY_BALL, 0.0, ">=", OTHER_HANDS)
    slip = 1e3 * holding.slip(hand, PAYLOAD)
    yield _check(f"slip of a {PAYLOAD:g} kg ball in lift and hold", slip, "mm", 1e3 * holding.LOSS_DISTANCE, 0.0, "<=")
    carried = "about 0.5 kg (Deimel and Brock, RSS 2014, as remembered)"
    yield _check("payload, lift and hold", holding.payload(hand), "kg", PAYLOAD, 0.0, ">=", carried)


def _sliding() -> Iterator[PhysicsCheck]:
    hand = Hand.load("rbo_hand2")
    slide = hand_slide(recorded_attempt("rbo_hand2"), hand)
    preshaped = degrees(hand_bench.free_bend(HandBench.build(hand), hand.parameters["use"]["preshape"]))
    yield _check("palm above the table in the push, least", 1e3 * slide.palm_clearance, "mm", 0.0, 0.0, ">=")
    yield _check("sensor above the table in the push, least", 1e3 * slide.sensor_clearance, "mm", 0.0, 0.0, ">=")
    yield _check("bend of the sliding fingers", degrees(slide.alone), "deg", preshaped, 0.0, ">=")
    yield _check("slope of the sliding fingertips", degrees(slide.tip_slope), "deg", degrees(hand.theta), 0.0, "<=")
    yield _check("table on the sliding hand", slide.table_force, "N", 5.0, 0.0, "<=")


def _scooping() -> Iterator[PhysicsCheck]:
    hand = Hand.load("shovel")
    slide = shovel_slide(recorded_attempt("shovel"), hand)
    wanted, edge = hand.parameters["use"]["normal_force"], 1e3 * slide.edge_height
    code = "5 N desired (ec_grasp_planner)"
    yield _check("shovel: table force while sliding, mean", slide.table_force, "N", wanted, 1.0, "=", code)
    yield _check("shovel: table force while sliding, peak", slide.peak_table_force, "N", 2.0 * wanted, 0.0, "<=")
    yield _check("shovel: leading edge above the table, most", edge, "mm", 0.0, 1.0, "=")
    yield _check("shovel: slope of the floor in the push", degrees(slide.slope), "deg", degrees(hand.theta), 1.0, "=")
    tilt = "18° in the lift (ec_grasp_planner)"
    angle = degrees(hand.use.scoop_angle)
    yield _check("shovel: tilt back in the scoop", degrees(slide.scoop_angle), "deg", angle, 2.0, "=", tilt)
