"""The rubber of a finger flattens under load."""

import math

import pytest

from own_hand import write_hand
from pilegrasp_ctrl.exceptions import ModelError
from pilegrasp_ctrl.sections import HandModelConfig
from pilegrasp_ctrl.sim.contact import SUPPORT, combine, pair_parameters
from pilegrasp_ctrl.sim.hand import Hand
from pilegrasp_ctrl.sim.pad import PAD_LOAD, soften
from pilegrasp_ctrl.validation.hand.squeeze import meeting_slope, thickness


@pytest.mark.parametrize("factor", [0.667, 1.333])
def test_each_side_of_a_fingertip_gives_way_as_stated(factor):
    hand = Hand.load("rbo_hand2", HandModelConfig(pad_give=factor))
    free, pressed = thickness(hand, 0.0), thickness(hand, PAD_LOAD)
    assert free == pytest.approx(2.0 * hand.parameters["fingers"]["radius_tip"], abs=1e-4)
    assert (free - pressed) / 2.0 == pytest.approx(0.003 * factor, rel=0.05)


def test_a_pad_stiffens_so_that_no_push_closes_it():
    hand = Hand.load("rbo_hand2")
    depths = [(thickness(hand, 0.0) - thickness(hand, load)) / 2.0 for load in (1.0, PAD_LOAD, 25.0)]
    assert depths[0] > 0.3 * depths[1]
    assert depths[2] < 2.0 * hand.parameters["pad"]["give"]


def test_a_pad_changes_neither_friction_nor_hard_parts():
    hand = Hand.load("rbo_hand2")
    assert set(hand.pads) == {name for name in hand.contact_geoms if name not in ("sensor",) and "palm" not in name}
    hard = pair_parameters(combine(hand.surface, SUPPORT, "paper"), 1e-3)
    soft = soften(hard, hand.pads["middle_4"], 0.0)
    assert soft.friction == hard.friction
    assert soft.solreffriction == hard.solref
    assert -soft.solref[0] < -hard.solref[0]


def test_a_thinner_tip_meets_a_ball_at_a_steeper_slope():
    assert math.degrees(meeting_slope(0.0, 0.027)) == pytest.approx(90.0)
    assert meeting_slope(0.007, 0.027) > meeting_slope(0.0135, 0.027) > meeting_slope(0.0135, 0.020)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ('give = 0.003\ngeoms = ["sponge_*"]', r"pad\.geoms has 'sponge_\*', which no geom matches"),
        ("give = 0.003", r"pad\.give and pad\.geoms belong together"),
    ],
)
def test_a_pad_that_is_nowhere_is_refused(tmp_path, table, words):
    folder = write_hand(tmp_path)
    toml = folder / "robot.toml"
    toml.write_text(f"{toml.read_text(encoding='utf-8')}\n[pad]\n{table}\n", encoding="utf-8")
    with pytest.raises(ModelError, match=words):
        Hand.load(folder).pads  # noqa: B018
