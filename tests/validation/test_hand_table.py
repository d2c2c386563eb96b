"""What the hands do is what their page says and what was asked of them."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from pilegrasp_ctrl.sections import HandModelConfig
from pilegrasp_ctrl.sim.hand import Hand
from pilegrasp_ctrl.validation.hand import holding
from pilegrasp_ctrl.validation.hand.hand_table import attempt, checks, measurements
from pilegrasp_ctrl.validation.hand.measurement import Measurement, markdown
from pilegrasp_ctrl.validation.hand.sliding import hand_course, hand_slide, shovel_slide
from places import DOCS

PAGE = (DOCS / "hand.md").read_text(encoding="utf-8")
ROW = re.compile(r"^\| ([^|]+) \| (-?[\d.e-]+) (\S+) \|", re.MULTILINE)


@pytest.fixture(scope="module")
def table():
    return measurements()


def test_everything_measured_is_as_it_should_be(table):
    assert [row.cells() for row in table if not row.ok] == []


def test_the_page_shows_what_is_measured(table):
    shown = {name: (float(value), unit) for name, value, unit in ROW.findall(PAGE)}
    assert shown.keys() == {row.name for row in table}, "python docs/studies/hand_table.py prints the table"
    for row in table:
        value, unit = shown[row.name]
        # Contacts may end a little differently with other versions of the engine.
        assert (unit, row.value) == (row.unit, pytest.approx(value, rel=0.05, abs=0.1)), row.name


def test_the_checks_are_plain(table, monkeypatch):
    monkeypatch.setattr("pilegrasp_ctrl.validation.hand.hand_table.measurements", lambda: table)
    for (name, requested, measured, tolerance, _, relation), row in zip(checks(), table, strict=True):
        assert (name, requested, measured) == (row.name, row.requested, row.value)
        assert tolerance >= 0.0
        assert relation in ("=", "<=", ">=")


def test_a_measurement_off_by_more_than_its_tolerance_is_not_ok():
    row = Measurement("length", 1.0, "m", 1.05, 0.1, "=")
    assert row.ok
    assert not replace(row, value=0.9).ok
    assert not replace(row, value=1.2).ok
    assert not replace(row, relation="<=", value=1.2).ok
    assert replace(row, relation="<=", value=0.0).ok
    assert not replace(row, relation=">=", value=0.9).ok
    assert replace(row, relation=">=", value=9.0).ok
    assert not replace(row, value=math.nan).ok
    assert "| length | 1 m | 1.05 ± 0.1 | none found |" in markdown((row,))


def test_the_sliding_hand_bends_its_fingers_and_keeps_its_palm_off_the_table():
    hand = Hand.load("rbo_hand2")
    slide, course = hand_slide(attempt("rbo_hand2"), hand), hand_course(attempt("rbo_hand2"), hand)
    assert slide.palm_clearance > 0.03
    assert slide.sensor_clearance > 0.03
    assert math.degrees(slide.alone) > 34.4  # of the preshape in the air
    assert slide.tip_slope < hand.theta - 0.5
    assert course.palm_height.min() <= slide.palm_clearance
    assert course.bend[-1] == pytest.approx(slide.at_trigger)


def test_the_shovel_slides_on_its_edge_alone():
    slide = shovel_slide(attempt("shovel"), Hand.load("shovel"))
    assert slide.heel_clearance > 0.01
    assert abs(slide.edge_height) < 1e-3


def test_a_recording_without_a_push_says_so():
    recording = attempt("rbo_hand2")
    cut = replace(recording, meta={**recording.meta, "outcomes": []})
    with pytest.raises(ValueError, match="without a push"):
        hand_slide(cut, Hand.load("rbo_hand2"))


def test_a_weak_hand_loses_what_the_shipped_one_holds():
    weak = Hand.load("rbo_hand2", HandModelConfig(closing_moment=0.2))
    assert holding.slip(weak, 0.5) > holding.LOST
    shipped = Hand.load("rbo_hand2")
    pulls = [holding.pull_out_force(hand, "along the fingers") for hand in (weak, shipped)]
    assert pulls[0] < 0.5 * pulls[1]


def test_the_hand_draws_a_ball_where_an_attempt_leaves_it():
    recording, hand = attempt("rbo_hand2"), Hand.load("rbo_hand2")
    names = [body.name for body in recording.bodies]
    on_bench = holding.ball_at_rest(hand)
    tool = recording.signals["tool_position"][-1]
    held = [i for i, name in enumerate(names) if name.startswith("object")]
    distance = np.linalg.norm(recording.body_position[-1, held] - tool, axis=1)
    assert distance.min() == pytest.approx(np.linalg.norm(on_bench), abs=0.03)
