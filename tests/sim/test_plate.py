"""The plate: a null model that pushes as wide as the RBO Hand 2, and cannot hold anything."""

import numpy as np
import pytest

import pilegrasp_ctrl as pg
from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.programs.attempt import prepare
from pilegrasp_ctrl.sim.hand import Hand


def test_the_plate_is_as_wide_and_as_heavy_as_the_hand_and_its_edge_is_at_the_fingertips():
    plate, soft = Hand.load("plate"), Hand.load("rbo_hand2")
    assert plate.use.half_width == soft.use.half_width
    assert plate.mass_properties().mass == pytest.approx(soft.mass_properties().mass)
    ours, theirs = plate.transform_tool_to_flange, soft.transform_tool_to_flange
    np.testing.assert_allclose(ours.translation, theirs.translation, atol=1e-9)
    # The same posture of the arm makes the plate upright and lets the fingers slope by their angle.
    turn = np.degrees(np.arccos(ours.rotation[:, 0] @ theirs.rotation[:, 0]))
    assert turn == pytest.approx(np.degrees(plate.theta - soft.theta), abs=0.01)
    np.testing.assert_allclose(ours.rotation[:, 1], theirs.rotation[:, 1], atol=1e-9)


def test_an_attempt_with_the_plate_has_no_grasp():
    plan = prepare(load_scenario("spheres_wall", {"hand": "plate", "pile.count": 3}), 0).plan
    assert [primitive.name for primitive in plan.primitives] == ["approach", "push", "lift"]


@pytest.mark.slow
def test_the_plate_pushes_until_f_grasp_and_holds_nothing():
    result = pg.run("spheres_wall", seed=0, overrides={"hand": "plate"})
    assert [outcome.trigger for outcome in result.outcomes] == ["surface contact", "grasp force", "lifted"]
    assert (result.success, result.grasped, result.carried["taken"]) == (False, 0, 0)


@pytest.mark.parametrize("key", ["preshape", "advance", "closing_moment"])
def test_keys_of_a_closing_hand_have_no_effect_on_the_plate(key):
    with pytest.raises(ConfigurationError, match=rf"hand_model\.{key} has no effect if hand = 'plate'"):
        load_scenario("spheres_wall", {"hand": "plate", f"hand_model.{key}": 0.2})
