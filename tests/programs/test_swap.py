"""Two hands at one pile: one pushes, then the pile lies as it was left, and another one closes."""

import numpy as np
import pytest

import pilegrasp_ctrl as pg
from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.programs.body_union import BodyUnion
from pilegrasp_ctrl.recording_parts import Body, Shape

SWAP = {"program": "swap", "strategy.pushing_hand": "plate", "pile.count": 5}


@pytest.fixture(scope="module")
def swapped():
    return pg.run("spheres_wall", seed=3, overrides=SWAP, record=True)


def bodies_of(recording, role):
    return [index for index, body in enumerate(recording.bodies) if body.role == role]


@pytest.mark.slow
def test_the_plate_pushes_like_in_a_push_of_its_own(swapped):
    alone = pg.run("spheres_wall", seed=3, overrides={"program": "push", "hand": "plate", "pile.count": 5})
    assert swapped.outcomes[:2] == alone.outcomes
    assert [outcome.name for outcome in swapped.outcomes[2:]] == ["approach", "take_over", "grasp", "lift"]
    assert swapped.config_hash != alone.config_hash


@pytest.mark.slow
def test_the_pile_lies_as_the_plate_left_it_until_the_hand_comes(swapped):
    recording = swapped.recording
    stop, again = swapped.outcomes[1].end, swapped.outcomes[2].start
    assert again - stop == pytest.approx(0.5, abs=1e-6)
    before = np.flatnonzero(recording.frame_time <= stop)[-1]
    after = np.flatnonzero(recording.frame_time >= again)[0]
    objects = bodies_of(recording, "object")
    moved = np.linalg.norm(recording.body_position[after, objects] - recording.body_position[before, objects], axis=1)
    # What the plate held against the wall bounces off and comes to rest; the others stay where they lie.
    *others, held = np.sort(moved)
    assert max(others) < 0.03
    assert held < 0.12


@pytest.mark.slow
def test_the_second_hand_comes_down_behind_the_place_where_the_first_one_stopped(swapped):
    recording, strategy = swapped.recording, load_scenario("spheres_wall").strategy
    tool = recording.signals["tool_position"]

    def at(time):
        return tool[np.flatnonzero(recording.signal_time <= time + 1e-9)[-1]]

    stop, touch = at(swapped.outcomes[1].end), at(swapped.outcomes[2].end)
    assert stop[0] - touch[0] == pytest.approx(strategy.clearance, abs=5e-3)


@pytest.mark.slow
def test_a_recording_shows_both_hands_and_no_contact_of_the_absent_one(swapped):
    recording = swapped.recording
    names = [body.name for body in recording.bodies]
    assert len(set(names)) == len(names)
    hands = bodies_of(recording, "hand")
    first = names.index("plate") if "plate" in names else hands[0]
    late = recording.frame_time > swapped.outcomes[2].start
    still = recording.body_position[late, first]
    assert np.ptp(still, axis=0) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("keys", [{"program": "swap"}, {"strategy.pushing_hand": "plate"}])
def test_a_second_hand_and_the_program_belong_together(keys):
    with pytest.raises(ConfigurationError, match=r"program = 'swap' and strategy\.pushing_hand.*belong together"):
        load_scenario("spheres_wall", keys)


def test_a_hand_that_is_not_known_is_refused():
    with pytest.raises(ConfigurationError, match=r"strategy\.pushing_hand = 'plaet' is not allowed: it must be"):
        load_scenario("spheres_wall", {"program": "swap", "strategy.pushing_hand": "plaet"})


def body(name, role, size=0.1):
    return Body(name, role, (Shape("sphere", [size, 0.0, 0.0], [0.0] * 3, [1.0, 0.0, 0.0, 0.0], [1.0] * 4),))


def test_bodies_of_two_scenes_are_joined_and_the_absent_ones_stand_at_the_arms_base():
    link, ball = body("link", "arm"), body("ball", "object")
    before = BodyUnion([link, body("hand", "hand"), ball])
    after = before.joined([link, body("hand", "hand", 0.2), body("thumb", "hand"), ball])
    assert [each.name for each in after.bodies] == ["link", "hand", "ball", "hand_2", "thumb"]
    assert after.indices.tolist() == [0, 3, 4, 2]
    positions = np.arange(12.0).reshape(4, 3)
    found, _ = after.place(positions, np.tile([1.0, 0.0, 0.0, 0.0], (4, 1)))
    assert found.tolist() == [positions[0].tolist(), positions[0].tolist(), *positions[[3, 1, 2]].tolist()]
    earlier, _ = after.completed(positions[:3], np.zeros((3, 4)))
    assert earlier[:3].tolist() == positions[:3].tolist()
    assert earlier[3:].tolist() == [positions[0].tolist()] * 2
