"""Factors of a scenario on the uncertain numbers of the hand and of the objects."""

import mujoco
import numpy as np
import pytest

from hand_files import flatten
from pilegrasp_ctrl import robots
from pilegrasp_ctrl.config import Scenario, build_scenario, load_scenario
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.hand_description import REPLACED, SCALED
from pilegrasp_ctrl.programs.attempt import prepare
from pilegrasp_ctrl.sections import HandModelConfig
from pilegrasp_ctrl.sim.hand import Hand
from pilegrasp_ctrl.sim.objects import objects_of
from pilegrasp_ctrl.validation.hand import hand_bench
from pilegrasp_ctrl.validation.hand.hand_bench import HandBench

RIGID = ("friction", "restitution", "sensor_mass")


def changes(hand, model):
    """Return the numbers of robot.toml that a model changes, with their ratio."""
    shipped, varied = flatten(Hand.load(hand).parameters), flatten(Hand.load(hand, model).parameters)
    return {key: varied[key] / shipped[key] for key in shipped if varied[key] != shipped[key]}


@pytest.mark.parametrize("factor", SCALED)
def test_a_factor_multiplies_its_numbers_and_no_other(factor):
    value = 0.8 if factor == "restitution" else 1.3
    found = changes("rbo_hand2", HandModelConfig(**{factor: value}))
    assert found.keys() == set(SCALED[factor])
    assert list(found.values()) == pytest.approx([value] * len(found))


def test_every_key_of_the_hand_model_has_an_effect():
    assert {*SCALED, *REPLACED} == set(HandModelConfig.model_fields)


@pytest.mark.parametrize("factor", RIGID)
def test_the_shovel_accepts_the_keys_of_a_rigid_hand(factor):
    scenario = build_scenario({"hand": "shovel"}, {f"hand_model.{factor}": 0.8})
    assert changes("shovel", scenario.hand_model) == pytest.approx({SCALED[factor][0]: 0.8})


@pytest.mark.parametrize("factor", [name for name in HandModelConfig.model_fields if name not in RIGID])
def test_the_shovel_rejects_the_keys_of_a_soft_hand(factor):
    with pytest.raises(ConfigurationError, match=rf"hand_model\.{factor} has no effect if hand = 'shovel'"):
        build_scenario({"hand": "shovel"}, {f"hand_model.{factor}": 0.1 if factor == "advance" else 0.8})


def test_advance_replaces_the_way_that_the_closing_hand_goes_on():
    shipped = prepare(load_scenario("spheres_wall"), 0).plan.primitives[2]
    still = prepare(load_scenario("spheres_wall", {"hand_model.advance": 0.0}), 0).plan.primitives[2]
    assert (shipped.name, shipped.advance, still.advance) == ("grasp", 0.06, 0.0)
    assert build_scenario({}, {"hand_model.advance": 0.0}).config_hash() != Scenario().config_hash()


def test_the_error_names_a_factor_out_of_range():
    with pytest.raises(ConfigurationError, match=r"hand_model\.friction = 9 is not allowed: it must be at most 5"):
        build_scenario({}, {"hand_model.friction": 9})


def test_the_factors_enter_the_hash_and_the_simulated_model():
    shipped = Scenario().config_hash()
    scenario = load_scenario("free_space_line", {"hand_model.bending_stiffness": 1.3, "hand_model.friction": 0.7})
    assert scenario.config_hash() != load_scenario("free_space_line").config_hash() != shipped
    model = prepare(scenario, 0).simulation.scene.model
    numbers = Hand.load("rbo_hand2").parameters
    assert model.joint("middle_bend_1").stiffness[0] == pytest.approx(1.3 * numbers["pneumatics"]["bending_stiffness"])
    touching = {model.geom("table").id, model.geom("middle_4").id}
    (pair,) = [i for i in range(model.npair) if {model.pair_geom1[i], model.pair_geom2[i]} == touching]
    assert model.pair_friction[pair, 0] == pytest.approx(0.7 * numbers["surface"]["lateral"])


def test_the_friction_factor_changes_all_friction_of_the_objects():
    shipped = objects_of(load_scenario("spheres_wall").pile)
    varied = objects_of(load_scenario("spheres_wall", {"pile.friction": 0.5}).pile)
    for name in ("lateral", "spinning", "rolling"):
        assert getattr(varied.surface, name) == 0.5 * getattr(shipped.surface, name)
    assert (varied.surface.restitution, varied.mass) == (shipped.surface.restitution, shipped.mass)
    assert Scenario().config_hash() != build_scenario({}, {"pile.friction": 0.5}).config_hash()


def test_loading_a_varied_hand_leaves_the_shipped_numbers_alone():
    Hand.load("rbo_hand2", HandModelConfig(bending_stiffness=2.0))
    assert Hand.load("rbo_hand2").parameters == robots.description("hands/rbo_hand2")


@pytest.fixture(scope="module")
def benches():
    models = [HandModelConfig(inflation_stiffness=share) for share in (0.0, 1.1)]
    return [HandBench.build(Hand.load("rbo_hand2", model)) for model in models]


def test_inflation_stiffness_does_not_change_the_shape_of_the_closed_hand(benches):
    plain, stiffened = benches
    assert hand_bench.free_bend(stiffened) == pytest.approx(hand_bench.free_bend(plain), abs=1e-3)
    assert hand_bench.stiffness(stiffened) == pytest.approx(hand_bench.stiffness(plain), rel=1e-6)
    assert hand_bench.stiffness(stiffened, 1.0) > 1.5 * hand_bench.stiffness(plain, 1.0)


def test_inflation_stiffness_is_a_share_of_the_springs(benches):
    """Equal moments bend all joints equally, so springs and air act in parallel."""
    _, bench = benches
    numbers = bench.hand.parameters["pneumatics"]
    closure, share = 0.5, numbers["inflation_stiffness"]
    free = closure * numbers["closing_moment"] * (1.0 + share) / (1.0 + closure * share) / numbers["bending_stiffness"]
    assert hand_bench.free_bend(bench, closure) == pytest.approx(4.0 * free, rel=1e-3)
    data = bench.start()
    data.ctrl[:] = data.act[:] = closure
    moment = 0.02
    for i in range(1, 5):
        data.joint(f"middle_bend_{i}").qfrc_applied[:] = moment
    mujoco.mj_step(bench.model, data, 2000)
    bends = np.array([data.joint(f"middle_bend_{i}").qpos[0] for i in range(1, 5)])
    added = moment / (numbers["bending_stiffness"] * (1.0 + closure * share))
    np.testing.assert_allclose(bends - free, added, rtol=0.01)
