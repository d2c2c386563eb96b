"""The motion pattern: known motions give known numbers, and every outcome of an attempt gives some."""

import json
from dataclasses import replace

import numpy as np
import pytest

from odd_recordings import ODD_RECORDINGS
from pilegrasp_ctrl.analysis.motion import annotate, measure, table_force
from pilegrasp_ctrl.analysis.push_motion import PushMotion
from pilegrasp_ctrl.episode import run
from pilegrasp_ctrl.recording import Body, Recording, Shape
from pushed_pile import (
    BEGIN,
    END,
    FRONT,
    HALF_WIDTH,
    RADIUS,
    RESTLESS,
    SPEED,
    at_rest,
    crowd,
    moving,
    push_recording,
)


@pytest.mark.parametrize("alpha", [0.0, 0.6])
def test_the_approach_speed_is_the_speed_of_the_hand_relative_to_the_objects_ahead(alpha):
    standing = measure(push_recording({"far": RESTLESS, "a": at_rest(0.21, 0.02)}, alpha=alpha))
    carried = measure(push_recording({"a": moving(0.05, 0.02, SPEED, 0.0)}, alpha=alpha))
    half = measure(push_recording({"a": moving(0.11, -0.04, 0.5 * SPEED, 0.0)}, alpha=alpha))
    assert standing["approach_speed"] == pytest.approx(SPEED, rel=1e-4)
    assert carried["approach_speed"] == pytest.approx(0.0, abs=1e-6)
    assert half["approach_speed"] == pytest.approx(0.5 * SPEED, rel=1e-4)
    assert half["hand_speed"] == pytest.approx(SPEED, rel=1e-4)


def test_objects_far_ahead_or_in_the_hand_do_not_count_as_approaching():
    found = measure(push_recording({"a": moving(0.5, 0.0, 0.01, 0.0), "b": moving(-0.02, 0.0, SPEED, 0.0)}))
    assert found["approach_speed"] is None


@pytest.mark.parametrize("alpha", [0.0, -0.4])
def test_the_spread_is_the_motion_away_from_the_nearer_end_of_the_leading_edge(alpha):
    # It keeps its place relative to the hand, so that the direction from the edge's end stays (3, 4) / 5.
    motions = {"a": moving(0.03, HALF_WIDTH + 0.04, SPEED, 0.0), "b": moving(0.03, -HALF_WIDTH - 0.04, SPEED, 0.0)}
    found = measure(push_recording(motions, alpha=alpha))
    assert found["spread_speed"] == pytest.approx(0.6 * SPEED, rel=1e-4)
    assert found["spread_forward"] == pytest.approx(SPEED, rel=1e-4)
    assert found["spread_sideways"] == pytest.approx(0.0, abs=1e-6)
    assert found["approach_speed"] is None


def test_sideways_means_away_from_the_middle_on_both_sides():
    found = measure(push_recording({"a": moving(0.3, 0.1, 0.0, 0.02), "b": moving(0.3, -0.1, 0.0, -0.02)}))
    assert found["spread_sideways"] == pytest.approx(0.02, rel=1e-4)


def test_the_measured_time_starts_with_the_motion_of_the_pile_and_ends_with_that_of_the_hand():
    late = push_recording({"a": lambda t: np.stack([0.2 + 0.05 * np.clip(t - 2.0, 0, 1), 0 * t], axis=-1)})
    push = PushMotion.of(late)
    assert push.time[0] == pytest.approx(2.0)
    assert push.time[-1] == pytest.approx(END)
    row = {"name": "push", "trigger": "travel limit: never", "start": BEGIN, "end": END + 0.5}
    waited = PushMotion.of(push_recording({"a": RESTLESS}, outcomes=[row]))
    assert waited.time[-1] == pytest.approx(END)


@pytest.mark.parametrize("strategy", [{"beta_deg": "20"}, {"beta_deg": 10**400}, {}, None])
def test_an_angle_that_is_not_a_number_counts_as_zero(strategy):
    motions = {"far": RESTLESS, "a": at_rest(0.17, 0.0)}
    found = measure(push_recording(motions, config={"strategy": strategy}))
    assert found == measure(push_recording(motions))


def test_a_thumb_above_the_objects_is_not_part_of_the_leading_edge():
    recording = push_recording({"far": RESTLESS, "a": at_rest(0.17, 0.0)})
    thumb = Body("thumb", "hand", (Shape("box", (0.03, 0.02, 0.01), (FRONT, -0.1, 2.5 * RADIUS)),))
    bodies = tuple(thumb if body.name == "thumb" else body for body in recording.bodies)
    found = measure(replace(recording, bodies=bodies))
    assert found == measure(recording)
    assert found["mouth_width"] == pytest.approx(2 * HALF_WIDTH)


def test_the_hand_speed_is_the_sliding_speed_even_if_a_wall_stops_the_hand():
    recording = push_recording({"far": RESTLESS})
    tool = recording.signals["tool_position"].copy()
    tool[:, 0] = np.minimum(tool[:, 0], tool[0, 0] + 0.7 * (tool[-1, 0] - tool[0, 0]))
    stopped = replace(recording, signals=recording.signals | {"tool_position": tool})
    assert measure(stopped)["hand_speed"] == pytest.approx(SPEED, rel=1e-4)


@pytest.mark.parametrize("recording", ODD_RECORDINGS.values(), ids=ODD_RECORDINGS.keys())
def test_every_outcome_has_the_same_keys(recording):
    found = measure(recording)
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    assert found.keys() - {"force_chains"} == measure(push_recording(crowd(0.0))).keys()
    assert isinstance(found["triggered"], bool)


def test_an_attempt_without_a_push_has_no_pattern():
    found = measure(ODD_RECORDINGS["failed approach"])
    assert found["triggered"] is False
    assert {found[name] for name in ("approach_speed", "spread_speed", "funnel_width", "separated")} == {None}


def test_annotating_adds_the_pattern_and_nothing_else():
    recording = push_recording({"far": RESTLESS, "a": at_rest(0.17, 0.0)})
    annotated = annotate(recording)
    assert annotated.meta["motion"] == measure(recording)
    assert {**annotated.meta, "motion": None} == {**recording.meta, "motion": None}
    assert np.array_equal(annotated.body_position, recording.body_position)
    assert annotate(ODD_RECORDINGS["failed approach"]) is ODD_RECORDINGS["failed approach"]


@pytest.fixture(scope="module")
def attempt():
    return run("spheres_wall", seed=0, record=True, overrides={"pile.count": 5})


@pytest.mark.slow
def test_a_real_attempt_shows_the_pattern(attempt):
    found = measure(attempt.recording)
    push = next(outcome for outcome in attempt.outcomes if outcome.name == "push")
    assert found["triggered"] is (push.trigger == "grasp force")
    assert len(found["held"]) == attempt.grasped
    assert 0.09 < found["hand_speed"] < 0.11
    assert 0.09 < found["mouth_width"] < 0.12
    assert 0.0 < found["approach_speed"] < found["hand_speed"] * 1.5
    assert found["separated"] is not None
    assert push.start < found["separated"]["time"] <= push.end


def pressed(vertical, outcomes):
    """Return a recording of a vertical force, sampled at 10 Hz."""
    return Recording(
        meta={"outcomes": outcomes},
        bodies=(Body("table", "support", (Shape("plane", (1.0, 1.0)),)),),
        frame_time=[0.0],
        body_position=[[[0.0, 0.0, 0.0]]],
        body_quaternion=[[[1.0, 0.0, 0.0, 0.0]]],
        signal_time=[0.1 * k for k in range(len(vertical))],
        signals={"wrench": [[0.0, 0.0, force, 0.0, 0.0, 0.0] for force in vertical]},
    )


def test_the_table_force_is_relative_to_the_force_in_the_air():
    outcomes = [{"name": "approach", "start": 0.0, "end": 0.45}, {"name": "push", "start": 0.45, "end": 0.75}]
    found = table_force(pressed([0.5, 0.5, 0.5, 0.5, 2.5, 4.5, 8.5, 6.5, 0.5], outcomes))
    assert found == pytest.approx({"mean": 6.0, "peak": 8.0})


def test_an_attempt_without_a_push_has_no_table_force():
    outcomes = [{"name": "approach", "start": 0.0, "end": 0.45}]
    assert table_force(pressed([0.5] * 9, outcomes)) is None
