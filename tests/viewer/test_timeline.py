"""The head of the page, its timeline and its table."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from page_parts import still, text_of
from pilegrasp_ctrl.recording import Shape
from pilegrasp_ctrl.viewer import page
from pilegrasp_ctrl.viewer.page.lane import ABOVE, BELOW, Curve, Lane, nice_ticks, thinned
from pilegrasp_ctrl.viewer.page.summary import summarize
from synthetic_recording import synthetic

HOSTILE = '</script><script>window.pwned=1</script><img src=x onerror="window.pwned=1">&"\'\ud800'


@pytest.fixture(scope="module")
def attempt():
    return synthetic()


@pytest.fixture(scope="module")
def document(attempt):
    return page(attempt)


def test_the_head_gives_verdict_time_and_reason():
    words = text_of(page(synthetic(success=False, frames=30)))
    assert "spheres_wall seed 0 Failed push: travel limit of 0.36 m before 17 N, at 6.4 s" in words
    assert "failed: travel limit of 0.36 m 2.20–6.40 360 11.2" in words
    words = text_of(page(synthetic(frames=30)))
    assert "Success: 2 objects held after 10.0 s · 2 taken: 2 kept hand rbo_hand2 object light_sphere count 18" in words
    assert "push grasp force 2.20–6.40 360 17.3" in words
    assert "mujoco 4.0.0" in words


def timeline_of(document):
    return document[document.index('<figure class="timeline"') : document.index("</figure>")]


def lane_of(document, title):
    """The HTML of one lane of the timeline."""
    parts = timeline_of(document).split('<div class="lane')[1:]
    (lane,) = [part for part in parts if f"<b>{title} [" in part]
    return lane


def curve_of(lane, style):
    (points,) = re.findall(rf'class="{style}" points="([^"]+)"', lane)
    return np.array([point.split(",") for point in points.split()], dtype=float)


def test_the_timeline_has_bands_curves_and_the_threshold():
    document = page(synthetic(frames=30))
    bands = re.findall(r'class="band (p\d)" style="left:([\d.]+)%;width:([\d.]+)%"', timeline_of(document))
    assert bands == [
        ("p0", "0.00", "22.00"),
        ("p1", "22.00", "42.00"),
        ("p2", "64.00", "12.00"),
        ("p3", "76.00", "24.00"),
    ]
    lane = lane_of(document, "force")
    curve = curve_of(lane, "c0")
    highest = curve[np.argmin(curve[:, 1])]
    (line,) = re.findall(r'class="threshold" x1="0" x2="1000" y1="([\d.]+)"', lane)
    # The push force passes 17 N shortly before 6.4 of 10 s and falls to zero there.
    assert 620 < highest[0] < 640
    assert highest[1] < float(line)
    assert "F_grasp 17 N" in lane
    assert len(curve_of(lane, "c1")) > 100


def test_every_lane_shows_its_signal_in_its_unit():
    document = page(synthetic(frames=30))
    titles = re.findall(r'<p class="legend"><b>([^<]+)</b>', timeline_of(document))
    assert titles == [
        "in the hand",
        "force [N]",
        "tracking error [mm]",
        "torques [% of limit]",
        "closure [%]",
        "orientation error [°]",
        "wrist force [N]",
        "wrist moment [N·m]",
        "joint positions [rad]",
        "joint velocities [rad/s]",
        "tool position [m]",
        "reference position [m]",
    ]
    hidden = re.findall(r'data-title="([^"]+)"[^>]* hidden>', timeline_of(document))
    assert [title.split(" [")[0] for title in titles[5:]] == hidden
    torques = lane_of(document, "torques")
    heights = {f"j{k}": curve_of(torques, f"j{k}")[:, 1] for k in range(7)}
    # 0.2 + 0.1 sin: every joint passes 10 % and 30 % of a lane that reaches from 0 to 100 %.
    for height in heights.values():
        assert np.ptp(height) == pytest.approx(20.0 * 46.0 / 58.0, abs=1.0)
    closure = curve_of(lane_of(document, "closure"), "c0")
    assert closure[0, 1] - closure[-1, 1] == pytest.approx(100.0 * 14.0 / 26.0, abs=1.0)
    error = curve_of(lane_of(document, "tracking error"), "c0")
    assert np.ptp(error[:, 1]) == pytest.approx(100.0 * 22.0 / 34.0, abs=1.0)


def test_the_numbers_of_two_lanes_stand_apart():
    # Without room at the ends, the 10 would stand on a number of the lane above.
    curve = Curve("x", np.array([0.0, 1.0]), np.array([-3.9, 9.9]), "c0")
    lane = Lane("x", "x", "N", [curve], 90)
    ups = [float(up) * lane.height / 100.0 for up, _ in lane.drawing(lane.axes(0.0, 1.0))["ticks"]]
    assert ups
    assert min(ups) >= BELOW - 0.01
    assert max(ups) <= lane.height - ABOVE + 0.01
    assert lane.drawing(lane.axes(0.0, 1.0))["ticks"][0][1] == "0"


def test_no_lane_has_numbers_closer_than_they_are_high():
    for lane in re.findall(r'<div class="lane" data-lane.*?</div>', timeline_of(page(synthetic(frames=30))), re.DOTALL):
        height = float(re.search(r"height:(\d+)px", lane)[1])
        ups = sorted(height * float(up) / 100.0 for up in re.findall(r'class="ty" style="bottom:([\d.]+)%"', lane))
        assert ups
        assert (np.diff(ups) >= 8.0).all()


def test_the_timeline_marks_the_events():
    saturated = np.zeros(1000)
    saturated[731:] = 1.0
    plain = synthetic(success=True, frames=30, motion={"separated": {"object": "light_sphere_01", "time": 4.5}})
    plain = replace(plain, signals=dict(plain.signals) | {"sensor_saturated": saturated})
    marks = re.findall(r'class="mark (\w+)" style="left:([\d.]+)%" title="([^"]+)"', page(plain))
    assert marks == [
        ("end", "22.00", "2.20 s: approach: touch force"),
        ("separation", "45.00", "4.50 s: light sphere 01 separates from the pile"),
        ("end", "64.00", "6.40 s: push: grasp force"),
        ("saturation", "73.10", "7.31 s: the wrist sensor is at its range"),
        ("end", "76.00", "7.60 s: grasp: closed"),
        ("end", "100.00", "10.00 s: lift: lifted"),
    ]
    failed = page(synthetic(success=False, frames=30))
    assert 'class="mark failure" style="left:100.00%" title="6.40 s: push: travel limit of 0.36 m"' in failed


def flat(force, **config):
    """A recording of two seconds with one force signal."""
    time = np.linspace(0.0, 2.0, 50)
    return still(
        [Shape("sphere", (0.03,))],
        signal_time=time,
        signals={"push_force": force * np.sin(20.0 * time), "tracking_error": 1e-3 * time},
        meta={"config": config},
    )


def test_the_sensors_noise_does_not_fill_the_lane():
    heights = {force: np.ptp(curve_of(lane_of(page(flat(force)), "force"), "c0")[:, 1]) for force in (0.05, 40.0)}
    assert heights[0.05] < 6.0
    assert heights[40.0] > 80.0


def test_a_failed_primitive_is_marked():
    document = page(synthetic(success=False, frames=30))
    assert 'class="band p1 failed"' in document
    assert 'class="band p0 failed"' not in document


def test_thinning_a_signal_keeps_its_peak():
    time = np.linspace(0.0, 10.0, 5000)
    value = np.sin(time)
    value[3217] = 80.0
    short_time, short_value = thinned(time, value)
    assert len(short_time) <= 502
    assert (np.diff(short_time) > 0.0).all()
    assert short_value.max() == 80.0
    assert short_time[np.argmax(short_value)] == time[3217]
    few_time, few_value = thinned(time, value, 0.02)
    assert len(few_time) < 60
    assert np.abs(np.interp(short_time, few_time, few_value) - short_value).max() <= 0.02


def test_ticks_are_round_numbers():
    assert nice_ticks(0.0, 10.0, 10) == [float(k) for k in range(11)]
    assert nice_ticks(-21.0, 23.0, 4) == [-20.0, 0.0, 20.0]
    assert nice_ticks(0.0, 0.23, 4) == pytest.approx([0.0, 0.1, 0.2])
    assert nice_ticks(1.0, 1.0, 4) == []


def test_the_summary_reads_the_recorded_keys():
    summary = summarize(
        {"config": {"strategy": {"grasp_force": 8, "alpha_deg": 0.0, "beta_deg": 15.0}}, "success": True}
    )
    assert summary.grasp_force == 8.0
    assert ("F_grasp", "8 N") in summary.facts
    assert ("beta", "15°") in summary.facts
    assert "alpha" not in dict(summary.facts)
    assert summary.verdict == "Success"
    line = summarize(
        {"config": {"program": "line", "hand": "shovel", "strategy": {"grasp_force": 8}}, "grasp_force": 8}
    )
    assert line.grasp_force is None
    assert line.facts == (("hand", "shovel"),)


def test_the_summary_leaves_out_unused_settings():
    config = {
        "program": "line",
        "pile": {"object": "cube", "count": 0},
        "line": {"speed": 0.2},
        "strategy": {"speed": 0.1},
    }
    assert dict(summarize({"config": config}).facts) == {"count": "0", "line speed": "0.2 m/s"}
    config |= {"program": "grasp", "pile": {"object": "cube", "count": 3}}
    assert dict(summarize({"config": config}).facts) == {"object": "cube", "count": "3", "speed": "0.1 m/s"}
