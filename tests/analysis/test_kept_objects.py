"""The object that separates during the push, and the objects that are held at the end."""

from dataclasses import replace

import numpy as np
import pytest

from pilegrasp_ctrl.analysis.kept_objects import HELD_DISTANCE, are_held
from pilegrasp_ctrl.analysis.motion import measure
from pilegrasp_ctrl.recording import Body, Shape
from pilegrasp_ctrl.recording_parts import Contacts
from pushed_pile import (
    BEGIN,
    END,
    FRONT,
    HALF_WIDTH,
    RADIUS,
    RESTLESS,
    SPEED,
    at_rest,
    moving,
    push_recording,
    sliding_in,
    yaw_quaternion,
)


def test_the_object_in_the_middle_has_separated_since_the_hand_is_beneath_it():
    motions = {"far": RESTLESS, "edge": sliding_in(0.05, 0.03, 0.01), "deep": sliding_in(0.1, 0.0, 0.04)}
    found = measure(push_recording(motions, held=("deep",)))
    assert found["separated"]["object"] == "deep"
    assert found["separated"]["time"] == pytest.approx(BEGIN + 1.0, abs=0.02)
    assert found["separated"]["stabilised"] == pytest.approx(BEGIN + 1.4, abs=0.02)
    assert found["in_hand"] == ["edge", "deep"]
    assert found["held"] == ["deep"]
    assert found["agreed"] is True


@pytest.mark.parametrize("aside", [0.8 * HALF_WIDTH, -0.025])
def test_of_two_that_came_in_side_by_side_the_one_nearer_to_the_middle_has_separated(aside):
    motions = {"far": RESTLESS, "deeper": sliding_in(0.05, aside, 0.08), "middle": sliding_in(0.15, 0.02, 0.03)}
    found = measure(push_recording(motions))
    assert found["in_hand"] == ["deeper", "middle"]
    assert found["separated"]["object"] == "middle"


def test_a_rigid_hand_keeps_the_deepest_object():
    motions = {"far": RESTLESS, "deeper": sliding_in(0.05, -0.025, 0.08), "middle": sliding_in(0.15, 0.02, 0.03)}
    found = measure(push_recording(motions, rigid=True))
    assert found["in_hand"] == ["deeper", "middle"]
    assert found["separated"]["object"] == "deeper"


@pytest.mark.parametrize("beta", [0.4, -0.4])
def test_the_middle_is_measured_in_the_frame_of_a_turned_hand(beta):
    x, y = np.array([np.cos(beta), np.sin(beta)]), np.array([-np.sin(beta), np.cos(beta)])
    own = np.array([0.2 - FRONT, 0.0]) + (FRONT - 0.09) * x
    beside = own + 0.03 * np.sign(beta) * y
    found = measure(push_recording({"far": RESTLESS, "own": at_rest(*own), "beside": at_rest(*beside)}, beta=beta))
    assert found["in_hand"] == ["own", "beside"]
    assert found["separated"]["object"] == "own"
    assert found["mouth_width"] == pytest.approx(2 * HALF_WIDTH)


def tip_and_deep(pair: tuple[str, str], x: float, y: float, alpha: float = 0.0) -> dict:
    """Measure a push that leaves one object before the leading edge and one in the hand, 40 mm beside its middle.

    Args:
        pair: names of the bodies that touch in all frames.
        x: how far before the edge the former lies at the end [m].
        y: how far to the left [m].
        alpha: of the push [rad].
    """
    motions = {"far": RESTLESS, "tip": at_rest(0.2 + x, y), "deep": sliding_in(0.1, -0.04, 0.04)}
    recording = push_recording(motions, alpha=alpha, held=("tip",))
    number = {body.name: index for index, body in enumerate(recording.bodies)}
    frames = recording.frame_time.size
    contacts = Contacts(
        np.arange(frames + 1),
        np.tile([number[name] for name in pair], (frames, 1)),
        np.zeros((frames, 3)),
        np.ones((frames, 3)),
    )
    return measure(replace(recording, contacts=contacts))


@pytest.mark.parametrize("alpha", [0.0, 2.5])
@pytest.mark.parametrize("pair", [("tip", "palm"), ("palm", "tip")])
def test_an_object_right_ahead_of_the_middle_is_preferred_to_one_beside_it(pair, alpha):
    found = tip_and_deep(pair, 0.2 * RADIUS, 0.0, alpha)
    assert found["separated"]["object"] == "tip"
    assert found["separated"]["stabilised"] is None
    assert found["separated"]["time"] == pytest.approx(END - 0.8 * RADIUS / SPEED, abs=0.02)
    assert found["in_hand"] == ["tip", "deep"]
    assert found["agreed"] is True


@pytest.mark.parametrize(
    ("pair", "x", "y"),
    [
        (("tip", "far"), 0.2 * RADIUS, 0.0),
        (("tip", "deep"), 0.2 * RADIUS, 0.0),
        (("far", "palm"), 0.2 * RADIUS, 0.0),
        (("tip", "palm"), 1.2 * RADIUS, 0.0),
        (("tip", "palm"), 0.2 * RADIUS, HALF_WIDTH + 0.005),
    ],
    ids=["touches an object", "touches what is in the hand", "not touched", "before the hand", "beside the hand"],
)
def test_an_object_ahead_of_the_hand_is_caught_only_if_the_fingertips_touch_it(pair, x, y):
    found = tip_and_deep(pair, x, y)
    assert found["separated"]["object"] == "deep"
    assert found["in_hand"] == ["deep"]


def test_an_object_farther_ahead_of_the_edge_must_be_nearer_to_the_middle():
    # |y| + 1.5 max(x + r / 2, 0): 45 against 40 mm; 15 against 20 and 5 mm.
    assert tip_and_deep(("tip", "palm"), 0.5 * RADIUS, 0.0)["separated"]["object"] == "deep"
    inside = {"far": RESTLESS, "edge": sliding_in(0.1, 0.0, 0.005), "deep": sliding_in(0.05, 0.02, 0.04)}
    assert measure(push_recording(inside))["separated"]["object"] == "edge"
    inside["deep"] = sliding_in(0.05, 0.005, 0.04)
    assert measure(push_recording(inside))["separated"]["object"] == "deep"


@pytest.mark.parametrize(
    ("slants", "kept"),
    [((20.0,), "right"), ((-20.0,), "left"), ((0.0,), "left"), ((45.0, -45.0), "left"), ((90.0, 20.0), "right")],
    ids=["nearer on the right", "nearer on the left", "square", "corner", "beside a wall along the way"],
)
@pytest.mark.parametrize("alpha", [0.0, 2.0])
def test_at_a_slanted_wall_the_hand_keeps_the_object_on_the_nearer_side(slants, kept, alpha):
    motions = {"far": RESTLESS, "left": sliding_in(0.1, 0.015, 0.03), "right": sliding_in(0.1, -0.025, 0.03)}
    recording = push_recording(motions, alpha=alpha)
    frames = recording.frame_time.size
    walls, turns = [], []
    for slant in slants:
        # The hand points to the left of the wall's normal by the slant.
        walls.append(Body(f"wall_{slant}", "support", (Shape("box", (0.01, 1.0, 0.1)), Shape("plane", (1.0, 1.0)))))
        turns.append(np.tile(yaw_quaternion(alpha - np.radians(slant)), (frames, 1, 1)))
    found = measure(
        replace(
            recording,
            bodies=(*recording.bodies, *walls),
            body_position=np.concatenate([recording.body_position, np.zeros((frames, len(walls), 3))], axis=1),
            body_quaternion=np.concatenate([recording.body_quaternion, *turns], axis=1),
        )
    )
    assert found["in_hand"] == ["left", "right"]
    assert found["separated"]["object"] == kept


def test_an_object_that_still_slides_in_is_not_stable():
    found = measure(push_recording({"far": RESTLESS, "a": at_rest(0.17, 0.0)}))
    assert found["separated"]["object"] == "a"
    assert found["separated"]["stabilised"] is None


@pytest.mark.parametrize(("x", "y"), [(0.0, HALF_WIDTH + 0.01), (0.25, 0.0), (-0.13 + 0.2, HALF_WIDTH * 2)])
def test_an_object_beside_or_ahead_of_the_hand_has_not_separated(x, y):
    found = measure(push_recording({"far": RESTLESS, "a": moving(x, y, SPEED * (x < 0.1), 0.0)}, held=("a",)))
    assert found["separated"] is None
    assert found["agreed"] is False


def test_motion_after_the_push_does_not_change_the_separated_object():
    motions = {"far": RESTLESS, "edge": sliding_in(0.05, 0.03, 0.01), "deep": sliding_in(0.1, 0.0, 0.04)}
    recording = push_recording(motions, held=("deep",))
    position = recording.body_position.copy()
    later = recording.frame_time > END + 1e-9
    position[later, 1:] += [0.3, -0.2, 0.0]
    changed = measure(replace(recording, body_position=position))
    assert changed["held"] == []
    assert {k: v for k, v in changed.items() if k not in ("held", "agreed")} == {
        k: v for k, v in measure(recording).items() if k not in ("held", "agreed")
    }


TOOL_AT = np.array([0.8, 0.0, 0.25])


IN_HAND = TOOL_AT + np.array([0.03, 0.0, 0.02])


def held(*positions, rest=0.027, lift=0.2):
    """Count, among objects at these positions that lay at the height `rest`, those in the hand at `TOOL_AT`."""
    places = np.array(positions, dtype=float).reshape(-1, 3)
    return int(are_held(places, TOOL_AT, np.full(len(places), rest), lift).sum())


def test_an_object_that_has_risen_and_is_near_counts_as_held():
    assert held(IN_HAND) == 1
    assert held(IN_HAND, TOOL_AT, [0.8, 0.0, 0.027]) == 2
    assert held() == 0


def test_a_risen_object_far_from_the_tool_does_not_count():
    aside = np.array([0.0, HELD_DISTANCE, 0.0])
    assert held(TOOL_AT + 0.99 * aside) == held(TOOL_AT - 0.99 * aside) == 1
    assert held(TOOL_AT + 1.01 * aside) == held(TOOL_AT - 1.01 * aside) == 0
    assert held([0.8, 0.0, 1.5]) == 0


def test_an_object_that_did_not_rise_does_not_count():
    assert held(IN_HAND, rest=IN_HAND[2] - 0.11) == 1
    assert held(IN_HAND, rest=IN_HAND[2] - 0.09) == 0
    assert held(IN_HAND, rest=IN_HAND[2] - 0.09, lift=0.1) == 1
