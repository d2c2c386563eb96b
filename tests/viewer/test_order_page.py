"""The page of an order is told by its attempts, each with its reason; every failure has a moment."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import pytest

from page_parts import text_of
from pilegrasp_ctrl.analysis.carried import count_carried
from pilegrasp_ctrl.viewer import page
from pilegrasp_ctrl.viewer.page.attempts import attempt_motions
from pilegrasp_ctrl.viewer.page.panel import Panel
from pilegrasp_ctrl.viewer.page.summary import summarize, tally
from pilegrasp_ctrl.viewer.scene.shapes import PALETTE
from synthetic_order import PERIOD, synthetic_order
from synthetic_recording import synthetic


@pytest.fixture(scope="module")
def order():
    return synthetic_order()


@pytest.fixture(scope="module")
def document(order):
    return page(order)


def test_the_head_counts_deliveries_and_attempts(document):
    words = text_of(document)
    assert "Failed: 1 of 2 delivered in 3 attempts, 2 dropped back after 34.0 s · 4 taken: 4 released" in words


def test_a_complete_order_is_told_without_a_share(order):
    attempts = [dict(row) | {"delivered": 2} for row in order.meta["attempts"][:1]]
    assert summarize({"success": True, "grasped": 2, "attempts": attempts}).verdict == (
        "Success: 2 delivered in 1 attempt"
    )


def test_the_table_groups_the_primitives_by_attempts(document):
    words = text_of(document)
    assert "attempt 1 ✓ 1 delivered 0.0–11.9 s, wall, 1 held approach" in words
    assert "attempt 2 ✗ 2 held where 1 were missing: dropped back 12.0–23.9 s, corner left, 2 held approach" in words
    assert "attempt 3 ✗ nothing was in the hand after the lift 24.0–34.0 s, wall, 0 held approach" in words
    groups = re.findall(r'<tbody class="attempt".*?</tbody>', document, flags=re.DOTALL)
    assert [group.count('<tr class="primitive') for group in groups] == [5, 5, 4]
    assert [group.count('<tr class="head failed"') for group in groups] == [0, 1, 1]


def test_the_timeline_has_a_band_for_each_attempt(document):
    spans = re.findall(
        r'class="span( failed)?" style="left:([\d.]+)%;width:([\d.]+)%" title="(attempt[^"]+)"', document
    )
    assert [span[0] for span in spans] == ["", " failed", " failed"]
    assert [float(span[1]) for span in spans] == pytest.approx([0.0, 100 * 12 / 34, 100 * 24 / 34], abs=0.01)
    assert spans[2][3] == "attempt 3, 24.0 to 34.0 s: 0 held, nothing was in the hand after the lift"


def test_a_failed_attempt_has_a_moment_and_a_red_mark(order):
    failures = [event for event in Panel.of(order).events if event.kind == "failure"]
    assert [event.words for event in failures] == [
        "attempt 2: 2 held where 1 were missing: dropped back",
        "attempt 3: nothing was in the hand after the lift",
    ]
    # What was dropped back failed when the hand had opened; an empty hand, in its lift.
    assert failures[0].time == pytest.approx(PERIOD + 11.9)
    assert 2 * PERIOD + 8.0 < failures[1].time < 2 * PERIOD + 9.0


def test_an_attempt_that_ends_without_a_failed_primitive_has_a_red_mark_all_the_same():
    recording = synthetic(success=True)
    recording = replace(recording, meta={**recording.meta, "success": False, "grasped": 0, "reason": "nothing held"})
    (failure,) = [event for event in Panel.of(recording).events if event.kind == "failure"]
    assert failure.words == "nothing held"
    assert 7.6 < failure.time < 10.0


def test_each_attempt_has_its_own_motion(order):
    motions = attempt_motions(order, summarize(order.meta))
    assert [(motion.start, motion.end) for motion in motions] == [
        (0.0, PERIOD),
        (PERIOD, 2 * PERIOD),
        (2 * PERIOD, 2 * PERIOD + 10.0),
    ]
    first, second, _ = motions
    assert second.push["start"] == pytest.approx(first.push["start"] + PERIOD, abs=0.04)
    assert second.separated[0] == first.separated[0]
    assert second.separated[1] == pytest.approx(first.separated[1] + PERIOD, abs=0.04)
    (data,) = json.loads(re.search(r'id="page-data">(.*?)</script>', page(order), flags=re.DOTALL)[1])
    assert data["ordered"] is True
    assert [one["push"]["start"] for one in data["attempts"]] == [motion.push["start"] for motion in motions]


def test_the_lane_of_the_hand_has_a_bar_for_each_object(document):
    bars = re.findall(r'class="bar (\w+)" data-object="(\w+)" style="left:[\d.]+%;width:[\d.]+%;top:(\d+)px"', document)
    assert [bar[:2] for bar in bars] == [("released", "light_sphere_00"), ("released", "light_sphere_01")] * 2
    # Attempts share the rows.
    assert [bar[2] for bar in bars] == ["2", "17", "2", "17"]


def test_bar_and_table_show_the_colour_that_the_object_has_in_the_scene(document):
    colors = [f"#{color:06x}" for color in PALETTE[:2]]
    bars = re.findall(r'<div class="bar[^>]*><i style="background:(#\w+)"></i>(\d+)</div>', document)
    assert bars == [(colors[0], "00"), (colors[1], "01")] * 2
    rows = re.findall(r'<i class="chip" style="background:(#\w+)"></i>(light sphere \d+)<', document)
    assert set(rows) == {(colors[0], "light sphere 00"), (colors[1], "light sphere 01")}


def test_the_tally_names_what_became_of_the_objects(order):
    assert tally(count_carried(Panel.of(synthetic()).carried), True) == "2 taken: 2 kept"
    assert tally({"taken": 2, "kept": 0, "released": 1, "lost": 1}, False) == "2 taken: 1 released, 1 lost"
    assert tally({"taken": 0}, True) == "nothing was in the hand"
    # The reason of a failure says so already.
    assert tally({"taken": 0}, False) == tally({}, True) == ""


@pytest.mark.parametrize(
    "attempts",
    ["many", [None, 3, {"start": 1}], [{"start": 2.0, "end": 1.0}], [{"start": 0.0, "end": 9.0, "held": "x"}]],
)
def test_odd_attempts_are_still_a_page(attempts):
    recording = synthetic(frames=30)
    assert "<html" in page(replace(recording, meta={**recording.meta, "attempts": attempts}))
