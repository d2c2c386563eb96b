"""All signals reach the page, to a 4096th of their range, and no peak is lost."""

from __future__ import annotations

import struct

import numpy as np
import pytest

from pilegrasp_ctrl.viewer.page.lanes import QUANTITIES, common_ranges, lanes
from pilegrasp_ctrl.viewer.page.signal_block import MAX_SAMPLES, STEPS, signal_block
from synthetic_recording import synthetic


def read(block):
    """Times and columns, as the page's script reads them."""
    samples, count = struct.unpack_from("<II", block)
    time = np.frombuffer(block, "<f4", samples, 8)
    ranges = np.frombuffer(block, "<f4", 2 * count, 8 + 4 * samples).reshape(-1, 2)
    content = np.frombuffer(block, "u1", 2 * samples * count, 8 + 4 * samples + 8 * count).reshape(count, 2, samples)
    steps = np.cumsum(content[:, 0].astype(int) + 256 * content[:, 1].astype(int), axis=1) & 0xFFFF
    return time, ranges[:, :1] + ranges[:, 1:] * steps


def test_the_block_holds_every_sample_to_a_4096th_of_the_range():
    rng = np.random.default_rng(3)
    time = np.linspace(0.0, 12.0, 1200)
    columns = [rng.normal(size=1200), 1e3 * np.sin(time), np.full(1200, -7.5)]
    found_time, found = read(signal_block(time, columns))
    np.testing.assert_allclose(found_time, time, atol=1e-5)
    for values, expected in zip(found, columns, strict=True):
        np.testing.assert_allclose(values, expected, atol=0.51 * np.ptp(expected) / STEPS + 1e-5)


def test_a_long_signal_keeps_its_peaks():
    time = np.linspace(0.0, 300.0, 30_000)
    value = np.sin(time)
    value[17_111] = 40.0
    found_time, (found,) = read(signal_block(time, [value]))
    assert found_time.size <= MAX_SAMPLES
    assert (np.diff(found_time) > 0.0).all()
    assert found.max() == pytest.approx(40.0, abs=0.01)
    assert abs(found_time[np.argmax(found)] - time[17_111]) < 0.11


def test_nothing_recorded_is_an_empty_block():
    assert signal_block(np.array([]), []) == b""
    assert signal_block(np.array([0.0]), []) == b""


def test_every_recorded_signal_has_a_lane():
    recording = synthetic(frames=30)
    named = {name for quantity in QUANTITIES for name in quantity.signals}
    assert set(recording.signals) <= named
    found = {lane.key: lane for lane in lanes(recording, 17.0)}
    assert {key: len(lane.curves) for key, lane in found.items()} == {
        "force": 2,
        "tracking": 1,
        "torques": 7,
        "closure": 1,
        "turning": 1,
        "wrench_force": 3,
        "wrench_moment": 3,
        "q": 7,
        "v": 7,
        "tool": 3,
        "reference": 3,
    }
    moment = found["wrench_moment"].curves[0].value
    np.testing.assert_allclose(moment, recording.signals["wrench"][:, 3])


def test_a_signal_of_ones_own_gets_a_lane_with_its_unit():
    from dataclasses import replace

    recording = synthetic(frames=30)
    signals = dict(recording.signals) | {"temperature": np.linspace(20.0, 30.0, recording.signal_time.size)}
    meta = {**recording.meta, "signal_units": {"temperature": "°C"}}
    (lane,) = [
        lane for lane in lanes(replace(recording, signals=signals, meta=meta), None) if lane.title == "temperature"
    ]
    assert (lane.unit, lane.shown, len(lane.curves)) == ("°C", False, 1)


def test_a_pair_is_drawn_to_one_scale():
    weak, strong = synthetic(success=False, frames=30), synthetic(frames=30)
    sides = [lanes(weak, 17.0), lanes(strong, 17.0)]
    ranges = common_ranges(sides)
    low, high = ranges["force"]
    assert low == min(side[0].range()[0] for side in sides)
    assert high == max(side[0].range()[1] for side in sides)
    drawn = [side[0].drawing(side[0].axes(0.0, 10.0, ranges["force"])) for side in sides]
    assert drawn[0]["ticks"] == drawn[1]["ticks"]
    assert (drawn[0]["low"], drawn[0]["high"]) == (drawn[1]["low"], drawn[1]["high"])
