"""The measurements of the hands agree with their page and with the requested values."""

import math
import re
from dataclasses import replace

import pytest

from pilegrasp_ctrl.exceptions import RecordingError
from pilegrasp_ctrl.sections import HandModelConfig
from pilegrasp_ctrl.sim.hand import Hand
from pilegrasp_ctrl.validation.hand import holding
from pilegrasp_ctrl.validation.hand.hand_table import markdown, measurements, recorded_attempt
from pilegrasp_ctrl.validation.hand.sliding import hand_course, hand_slide, shovel_slide
from pilegrasp_ctrl.validation.physics import suite
from pilegrasp_ctrl.validation.physics.physics_check import PhysicsCheck
from places import DOCS

pytestmark = pytest.mark.slow

PAGE = (DOCS / "hand.md").read_text(encoding="utf-8")
ROW = re.compile(r"^\| ([^|]+) \| (-?[\d.e-]+) (\S+) \|", re.MULTILINE)


@pytest.fixture(scope="module")
def table():
    return measurements()


def test_every_measurement_of_the_hands_is_within_its_tolerance(table):
    assert [row for row in table if not row.ok] == []


def test_the_page_of_the_hands_shows_the_measured_numbers(table):
    shown = {name: (float(value), unit) for name, value, unit in ROW.findall(PAGE)}
    assert shown.keys() == {row.name for row in table}, "python docs/studies/hand_table.py prints the table"
    for row in table:
        value, unit = shown[row.name]
        # Contacts may end a little differently with other versions of the engine.
        assert (unit, row.measured) == (row.unit, pytest.approx(value, rel=0.05, abs=0.1)), row.name


def test_a_row_of_the_page_states_unit_tolerance_and_source():
    check = PhysicsCheck("length", 1.05, 1.0, 0.1, "m")
    assert "| length | 1 m | 1.05 ± 0.1 | none found |" in markdown((check,))
    bound = PhysicsCheck("length", 1.05, 1.0, 0.1, "m", "<=", published="1 m (a paper)")
    assert "| length | 1 m | ≤ 1.05 | 1 m (a paper) |" in markdown((bound,))


def test_doctor_reports_the_measurements_as_checks_of_the_hand(table, monkeypatch):
    monkeypatch.setattr(suite, "measurements", lambda: table)
    assert [check.name for check in suite.hand_checks()] == [f"hand: {check.name}" for check in table]
    assert [check.measured for check in suite.hand_checks()] == [check.measured for check in table]


def test_the_sliding_hand_bends_its_fingers_and_keeps_its_palm_off_the_table():
    hand = Hand.load("rbo_hand2")
    slide, course = hand_slide(recorded_attempt("rbo_hand2"), hand), hand_course(recorded_attempt("rbo_hand2"), hand)
    assert slide.palm_clearance > 0.03
    assert slide.sensor_clearance > 0.03
    assert math.degrees(slide.alone) > 34.4  # of the preshape in the air
    assert slide.tip_slope < hand.theta - 0.5
    assert course.palm_height.min() <= slide.palm_clearance
    assert course.bend[-1] == pytest.approx(slide.at_trigger)


def test_the_shovel_slides_on_its_edge_alone():
    slide = shovel_slide(recorded_attempt("shovel"), Hand.load("shovel"))
    assert slide.heel_clearance > 0.01
    assert abs(slide.edge_height) < 1e-3


def test_a_recording_without_a_push_is_refused_with_the_reason():
    recording = recorded_attempt("rbo_hand2")
    cut = replace(recording, meta={**recording.meta, "outcomes": []})
    with pytest.raises(RecordingError, match="without a push"):
        hand_slide(cut, Hand.load("rbo_hand2"))


def test_a_weak_hand_loses_the_ball_that_the_shipped_hand_holds():
    weak = Hand.load("rbo_hand2", HandModelConfig(closing_moment=0.2))
    assert holding.slip(weak, 0.5) > holding.LOSS_DISTANCE
    shipped = Hand.load("rbo_hand2")
    pulls = [holding.pull_out_force(hand, "along the fingers") for hand in (weak, shipped)]
    assert pulls[0] < 0.5 * pulls[1]
