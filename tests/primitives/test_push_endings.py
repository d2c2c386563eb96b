"""Events that end a push before F_grasp, and F_grasp by the mass of the objects."""

import numpy as np
import pytest

from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.primitives.grasp import Grasp
from pilegrasp_ctrl.primitives.guarded_motions import Push
from pilegrasp_ctrl.primitives.primitive import PrimitiveInput, Setpoint
from pilegrasp_ctrl.primitives.push_endings import BREAK, PUSH_ENDINGS, TOUCH_TIME
from pilegrasp_ctrl.programs.attempt import with_force_by_mass
from pilegrasp_ctrl.sim.objects import objects_of
from pilegrasp_ctrl.types import Pose, Reference

ALONG = np.array([1.0, 0.0, 0.0])
HERE = Pose(np.zeros(3))


def felt(time, force=0.0, touched=0, inside=0):
    return PrimitiveInput(time, HERE, np.array([-force, 0.0, 0.0, 0.0, 0.0, 0.0]), touched, inside)


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


def test_an_object_behind_a_fingertip_ends_the_push_although_its_touch_breaks_for_a_moment():
    active = push(PUSH_ENDINGS["inside"])
    assert active.ending(felt(0.0, touched=3)) is None, "tips alone"
    assert active.ending(felt(1.0, touched=3)) is None, "tips alone"
    assert active.ending(felt(1.1, touched=1, inside=1)) is None
    assert active.ending(felt(1.1 + 1.1 * BREAK)) is None
    assert active.ending(felt(1.2 + BREAK, inside=1)) is None, "the first touch was broken for too long"
    for step in range(1, 20):
        time = 1.2 + BREAK + step * 0.5 * BREAK
        ending = active.ending(felt(time, inside=step % 2 == 0))
        if ending is not None:
            break
    assert (ending.trigger, ending.failed) == ("an object touched a finger behind its tip", False)
    assert time - 1.2 - BREAK == pytest.approx(TOUCH_TIME)


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


@pytest.mark.parametrize(("link", "inside"), [("middle_2", 1), ("middle_4", 0)])
def test_fingers_feel_the_objects_that_they_touch(link, inside):
    import mujoco

    from pilegrasp_ctrl.programs.attempt import prepare

    attempt = prepare(load_scenario("spheres_wall", {"strategy.close_on": "touches", "pile.count": 2}), 0)
    simulation = attempt.simulation
    assert (simulation.observe().touched, simulation.observe().inside) == (0, 0)
    scene, data = simulation.scene, simulation.data
    radius = 0.027
    finger = scene.model.body(link).id
    down = np.array([0.0, 0.0, -1.0])
    for depth in np.arange(0.0, 0.05, 0.001):
        place = data.xipos[finger] + (radius + 0.03 - depth) * down
        data.qpos[scene.object_qpos : scene.object_qpos + 3] = place
        mujoco.mj_forward(scene.model, data)
        if simulation.observe().touched:
            break
    assert (simulation.observe().touched, simulation.observe().inside) == (1, inside)
