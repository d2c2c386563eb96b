"""Fingers touch one another and the palm, and twist at their base."""

from dataclasses import replace

import numpy as np
import pytest

from own_hand import write_hand
from pilegrasp_ctrl.exceptions import ModelError
from pilegrasp_ctrl.sim.hand import Hand
from pilegrasp_ctrl.validation.hand.hand_bench import SETTLING, HandBench, axes, touch_depth

PUSH = 10.0  # N


def shipped():
    return Hand.load("rbo_hand2")


def without_touch(hand):
    return replace(hand, parameters={**hand.parameters, "touch": {"pairs": []}})


def pushed_aside(hand):
    """Push the middle fingertip toward the ring finger; return how far each of the two goes along the push [m]."""
    bench = HandBench.build(hand)
    data = bench.start()
    names = ("middle", "ring")
    before = {name: bench.fingertip(data, name) for name in names}
    way = before["ring"] - before["middle"]
    way /= np.linalg.norm(way)
    while data.time < SETTLING:
        bench.load(data, "middle", PUSH * way)
        bench.advance(data, 0.01)
    return [float((bench.fingertip(data, name) - before[name]) @ way) for name in names]


def test_a_finger_that_is_pushed_aside_takes_its_neighbour_along():
    alone, pushed = pushed_aside(without_touch(shipped())), pushed_aside(shipped())
    assert alone[1] == pytest.approx(0.0, abs=1e-4)
    assert pushed[1] > 0.005
    assert pushed[0] < alone[0] - 0.003


def test_a_finger_does_not_pass_through_its_neighbour():
    radius = shipped().parameters["fingers"]["radius_tip"]
    assert touch_depth(HandBench.build(shipped()), 0.8 * PUSH) < radius
    assert touch_depth(HandBench.build(without_touch(shipped())), 0.8 * PUSH) > 1.5 * radius


def test_the_base_of_a_finger_twists_by_its_stiffness():
    bench = HandBench.build(without_touch(shipped()))
    closing, sideways = axes(bench)
    data = bench.start()
    body = bench.model.body("middle_4").id
    moment = 0.01
    along = np.cross(sideways, closing)
    while data.time < SETTLING:
        data.xfrc_applied[body, 3:] = moment * along
        bench.advance(data, 0.01)
    twist = abs(data.joint("middle_twist").qpos[0])
    assert twist == pytest.approx(moment / shipped().parameters["pneumatics"]["twist_stiffness"], rel=0.05)


def test_pairs_are_geoms_that_touch_and_fingers_reach_neither_themselves_nor_their_own_base():
    pairs = shipped().touching_pairs
    assert ("middle_4", "ring_4") in pairs
    assert ("palm_pad", "thumb_4") in pairs
    assert all(one.rpartition("_")[0] != other.rpartition("_")[0] for one, other in pairs)
    assert ("index_1", "palm_pad") not in pairs


def test_a_pair_that_the_hand_does_not_have_is_refused(tmp_path):
    folder = write_hand(tmp_path)
    toml = folder / "robot.toml"
    toml.write_text(f'{toml.read_text(encoding="utf-8")}\n[touch]\npairs = [["floor", "lid"]]\n', encoding="utf-8")
    with pytest.raises(ModelError, match=r"touch\.pairs has 'lid', which no geom matches; these touch: .*floor"):
        Hand.load(folder).touching_pairs  # noqa: B018
