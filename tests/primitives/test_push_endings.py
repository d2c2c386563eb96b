"""Events that end a push before F_grasp, and F_grasp by the mass of the objects."""

import numpy as np
import pytest

from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.primitives.grasp import Grasp
from pilegrasp_ctrl.primitives.guarded_motions import Push
from pilegrasp_ctrl.primitives.primitive import PrimitiveInput, Setpoint
from pilegrasp_ctrl.primitives.push_endings import PUSH_ENDINGS, TOUCH_TIME
from pilegrasp_ctrl.programs.attempt import with_force_by_mass
from pilegrasp_ctrl.sim.objects import objects_of
from pilegrasp_ctrl.types import Pose, Reference

ALONG = np.array([1.0, 0.0, 0.0])
HERE = Pose(np.zeros(3))


def felt(time, force=0.0, touched=0):
    return PrimitiveInput(time, HERE, np.array([-force, 0.0, 0.0, 0.0, 0.0, 0.0]), touched)


def push(endings):
    return Push(ALONG, 0.1, 17.0, 0.5, 0.0, 2.0, 0.3, endings).begin(felt(0.0), Setpoint(Reference(HERE), 0.3))


def test_two_objects_that_touch_for_long_enough_end_the_push():
    active = push(PUSH_ENDINGS["touches"])
    assert active.ending(felt(0.0, touched=2)) is None
    assert active.ending(felt(0.5 * TOUCH_TIME, touched=1)) is None
    assert active.ending(felt(0.6 * TOUCH_TIME, touched=3)) is None
    assert active.ending(felt(1.5 * TOUCH_TIME, touched=2)) is None, "the first touch was broken"
    ending = active.ending(felt(1.7 * TOUCH_TIME, touched=2))
    assert (ending.trigger, ending.failed) == ("2 objects touched the fingers", False)


def test_f_grasp_ends_every_push_and_touches_no_push_that_does_not_feel_them():
    for endings in PUSH_ENDINGS.values():
        assert push(endings).ending(felt(0.1, force=17.5)).trigger == "grasp force"
    active = push(PUSH_ENDINGS["force"])
    assert [active.ending(felt(time, touched=5)) for time in (0.0, 1.0)] == [None, None]


def test_after_a_touch_the_grasp_goes_on_along_the_push_at_once():
    def advance(start_force):
        grasp = Grasp(1.0, ALONG, 0.1, 17.0, 0.05, start_force)
        active = grasp.begin(felt(0.0, force=1.0), Setpoint(Reference(HERE), 0.3))
        return [active.setpoint(felt(time, force=1.0)) for time in (0.0, 0.1)][1].reference.pose.translation[0]

    assert advance(None) == 0.0
    assert advance(0.0) == pytest.approx(0.01)


def test_f_grasp_follows_the_mass_of_an_object():
    scenario = load_scenario("spheres_alone", {"strategy.force_per_mass": 50.0, "pile.object": "heavy_sphere"})
    planned = with_force_by_mass(scenario, objects_of(scenario.pile))
    assert planned.strategy.grasp_force == pytest.approx(50.0 * 0.18)
    plain = load_scenario("spheres_alone")
    assert with_force_by_mass(plain, objects_of(plain.pile)) is plain


def test_a_force_by_mass_excludes_another_one():
    with pytest.raises(ConfigurationError, match=r"strategy\.grasp_force"):
        load_scenario("spheres_alone", {"strategy.force_per_mass": 50.0, "strategy.grasp_force": 8.0})


def test_the_keys_count_in_the_hash_unless_neutral():
    plain = load_scenario("spheres_wall").config_hash()
    neutral = {"strategy.close_on": "force"}
    assert load_scenario("spheres_wall", neutral).config_hash() == plain
    for change in ({"strategy.close_on": "touches"}, {"strategy.force_per_mass": 50.0}):
        assert load_scenario("spheres_wall", change).config_hash() != plain


def test_fingers_feel_the_objects_that_they_touch():
    from pilegrasp_ctrl.programs.attempt import prepare

    attempt = prepare(load_scenario("spheres_wall", {"strategy.close_on": "touches", "pile.count": 2}), 0)
    simulation = attempt.simulation
    assert simulation.observe().touched == 0
    scene, data = simulation.scene, simulation.data
    finger = next(body for body in scene.hand_bodies if scene.model.body(body).name.startswith("middle"))
    simulation.data.qpos[scene.object_qpos : scene.object_qpos + 3] = data.xpos[finger] + [0.0, 0.0, -0.02]
    import mujoco

    mujoco.mj_forward(scene.model, data)
    assert simulation.observe().touched == 1
