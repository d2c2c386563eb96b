"""The simulated arm differs from its model within the spread of its robot.toml."""

import numpy as np
import pytest

from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.exceptions import ModelError
from pilegrasp_ctrl.planning.arm_bodies import _spread
from pilegrasp_ctrl.planning.simulated_arm import ArmSpread, simulated_arm
from pilegrasp_ctrl.programs.attempt import prepare
from pilegrasp_ctrl.sim.arm_spread import ArmFactors, draw_factors

NOMINAL = ArmFactors(np.ones(7), 1.0)


def model_of(name, seed=0, **keys):
    return prepare(load_scenario(name, keys), seed).simulation.scene.model


def test_factors_fill_the_spread_and_follow_from_the_seed():
    spread = ArmSpread(0.3, 0.03)
    drawn = [draw_factors(spread, NOMINAL, seed) for seed in range(200)]
    friction, mass = np.array([each.friction for each in drawn]), np.array([each.mass for each in drawn])
    for values, width in ((friction, 0.3), (mass, 0.03)):
        assert np.abs(values - 1.0).max() <= width
        assert values.min() < 1.0 - 0.9 * width
        assert values.max() > 1.0 + 0.9 * width
    # Each joint has a factor of its own.
    assert np.abs(np.corrcoef(friction.T) - np.eye(7)).max() < 0.25
    again = draw_factors(spread, NOMINAL, 3)
    assert (again.mass, list(again.friction)) == (drawn[3].mass, list(drawn[3].friction))
    assert draw_factors(spread, NOMINAL, None) is NOMINAL


def test_a_push_has_a_drawn_arm_and_a_line_in_free_space_the_nominal_one():
    push, line = model_of("push_wall"), model_of("free_space_line")
    factors = draw_factors(simulated_arm("wam7").spread, NOMINAL, 0)
    np.testing.assert_allclose(push.dof_frictionloss[:7], line.dof_frictionloss[:7] * factors.friction)
    weights = [model.body("link1").mass[0] for model in (push, line)]
    assert weights[0] == pytest.approx(weights[1] * factors.mass)
    assert push.body("sensor").mass == line.body("sensor").mass
    assert push.body("base_link").subtreemass[0] != line.body("base_link").subtreemass[0]


def test_keys_move_the_middle_of_the_band():
    usual, moved = model_of("push_wall"), model_of("push_wall", **{"sim.joint_friction": 1.5, "sim.arm_mass": 1.1})
    np.testing.assert_allclose(moved.dof_frictionloss[:7], 1.5 * usual.dof_frictionloss[:7])
    assert moved.body("link2").mass[0] == pytest.approx(1.1 * usual.body("link2").mass[0])


@pytest.mark.parametrize("stated", [{"friction": 1.0}, {"mass": -0.1}, {"mass": "3 %"}, 0.3])
def test_a_spread_that_is_no_share_is_refused(stated):
    with pytest.raises(ModelError, match=r"spread\..* must be a share from 0 to below 1"):
        _spread({"spread": stated}, "mine")
