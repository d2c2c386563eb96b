"""Each primitive continues the last reference, and ends by events that it takes from its inputs."""

import numpy as np
import pytest

from pilegrasp_ctrl.planning.strategy import tool_rotation
from pilegrasp_ctrl.primitives.free_motions import Carry, Lift, Move
from pilegrasp_ctrl.primitives.grasp import Grasp, Release, Scoop
from pilegrasp_ctrl.primitives.guarded_motions import Approach, Push
from pilegrasp_ctrl.primitives.primitive import PrimitiveInput, Setpoint
from pilegrasp_ctrl.types import Pose, Reference

X = np.array([1.0, 0.0, 0.0])
HERE = Pose([0.6, 0.0, 0.25], tool_rotation(0.0, 0.8))


def inputs(time, pose=HERE, force=(0.0, 0.0, 0.0)):
    return PrimitiveInput(time, pose, np.array([*force, 0.0, 0.0, 0.0]))


def still(pose=HERE, closure=0.3):
    return Setpoint(Reference(pose), closure)


APPROACH = Approach(HERE.moved([0.1, 0.0, -0.19]), 0.06, 0.15, 0.05, 1.8, 0.3)
PUSH = Push(X, 0.1, 17.0, 0.3, 0.006, 0.0, 0.3)
PRIMITIVES = [
    APPROACH,
    PUSH,
    Grasp(2.0, X, 0.1, 17.0, 0.06),
    Scoop(0.8, 0.11, 0.17),
    Lift(0.2, 0.12, 1.0),
    Lift(0.2, 0.12, 1.0, back=-0.06 * X),
    Move(0.3 * X, 0.1),
    Carry(Pose([0.5, 0.3, 0.3], tool_rotation(0.5, 0.8)), 0.25, 1.0),
    Release(1.0),
]


@pytest.mark.parametrize("primitive", PRIMITIVES, ids=lambda primitive: primitive.name)
def test_the_reference_continues_from_the_last_one_and_never_jumps(primitive):
    active = primitive.begin(inputs(3.0), still())
    setpoints = [active.setpoint(inputs(3.0 + 0.002 * k)) for k in range(3000)]
    np.testing.assert_allclose(setpoints[0].reference.pose.translation, HERE.translation, atol=1e-12)
    np.testing.assert_allclose(setpoints[0].reference.pose.rotation, HERE.rotation, atol=1e-12)
    np.testing.assert_allclose(setpoints[0].reference.twist, 0.0, atol=1e-12)
    steps = np.diff([setpoint.reference.pose.translation for setpoint in setpoints], axis=0)
    assert np.abs(steps).max() < 0.002 * 0.5
    assert np.abs(np.diff(steps, axis=0)).max() < 0.002**2 * 2.0


def test_approach_ends_at_the_surface_only_on_the_way_down():
    active = APPROACH.begin(inputs(0.0, force=(0.0, 0.0, 0.5)), still())
    down = active.path.lines[0].duration
    assert active.ending(inputs(down + 0.3, force=(0.0, 0.0, 2.2))) is None
    ending = active.ending(inputs(down + 0.3, force=(0.0, 0.0, 2.4)))
    assert (ending.trigger, ending.failed) == ("surface contact", False)
    assert active.ending(inputs(0.5 * down, force=(0.0, 0.0, 3.0))) is None
    assert active.ending(inputs(0.5 * down, force=(-20.0, 0.0, 0.0))).failed
    assert active.ending(inputs(active.path.duration + 1.0)).failed


def test_approach_searches_five_centimetres_below_the_expected_surface():
    end = APPROACH.begin(inputs(0.0), still()).path.end.translation
    assert end[2] == pytest.approx(APPROACH.pre_grasp.translation[2] - 0.06 - 0.05)


@pytest.mark.parametrize(("force", "collides"), [(8.9, False), (9.1, True)])
def test_five_times_the_touch_force_in_free_space_is_a_collision(force, collides):
    active = APPROACH.begin(inputs(0.0), still())
    ending = active.ending(inputs(0.5 * active.path.lines[0].duration, force=(0.0, -force, 0.0)))
    assert (ending is not None and ending.failed) == collides


def test_push_triggers_on_the_force_along_the_push_relative_to_its_start():
    active = PUSH.begin(inputs(1.0, force=(-3.0, 0.0, 4.0)), still())
    assert active.force(inputs(2.0, force=(-13.0, 0.0, 4.0))) == pytest.approx(10.0)
    assert active.ending(inputs(2.0, force=(-19.9, 0.0, 4.0))) is None
    assert active.ending(inputs(2.0, force=(-3.0, 40.0, 40.0))) is None
    ending = active.ending(inputs(2.0, force=(-20.0, 0.0, 4.0)))
    assert (ending.trigger, ending.failed) == ("grasp force", False)
    late = active.ending(inputs(1.0 + active.path.duration + 0.6))
    assert late.failed
    assert "never reached" in late.trigger


def test_push_slides_below_touch_down_and_asks_for_its_normal_force():
    touch = HERE.moved([0.0, 0.0, -0.24])
    active = Push(X, 0.1, 17.0, 0.3, 0.006, 5.0, 0.0).begin(inputs(0.0, touch), still(HERE.moved([0.0, 0.0, -0.245])))
    middle = active.setpoint(inputs(active.path.duration - 0.5 * active.path.lines[1].duration, touch))
    assert middle.reference.pose.translation[2] == pytest.approx(touch.translation[2] - 0.006)
    np.testing.assert_allclose(middle.reference.twist[:3], 0.1 * X, atol=1e-12)
    np.testing.assert_allclose(middle.desired_force[:3], [0.0, 0.0, -5.0])


def test_push_sinks_slowly_to_the_press_depth():
    active = PUSH.begin(inputs(0.0), still(HERE.moved([0.0, 0.0, 0.05])))
    speeds = [active.path.lines[0].at(time).twist[2] for time in np.linspace(0.0, active.path.lines[0].duration, 101)]
    assert min(speeds) == pytest.approx(-0.04)


def test_grasp_closes_and_follows_objects_that_yield():
    active = Grasp(2.0, X, 0.1, 17.0, 0.03).begin(inputs(1.0, force=(-20.0, 0.0, 0.0)), still())
    held = active.setpoint(inputs(1.0, force=(-20.0, 0.0, 0.0)))
    assert held.closure == 1.0
    np.testing.assert_allclose(held.reference.twist, 0.0, atol=1e-12)
    half = active.setpoint(inputs(1.1, force=(-11.5, 0.0, 0.0)))
    np.testing.assert_allclose(half.reference.twist[:3], 0.05 * X)
    np.testing.assert_allclose(half.reference.pose.translation, HERE.translation + 0.005 * X)
    far = active.setpoint(inputs(2.1, force=(-3.0, 0.0, 0.0)))
    np.testing.assert_allclose(far.reference.pose.translation, HERE.translation + 0.03 * X)
    back = active.setpoint(inputs(2.2, force=(-37.0, 0.0, 0.0)))
    np.testing.assert_allclose(back.reference.pose.translation, HERE.translation + 0.02 * X)
    assert active.ending(inputs(2.9)) is None
    assert active.ending(inputs(3.0)).trigger == "closed"


def test_scoop_tilts_about_its_heel_without_pressing_it_into_the_table():
    slope, angle, length = 0.17, 0.8, 0.11
    edge = Pose([0.9, 0.0, 0.0], tool_rotation(0.0, slope))
    active = Scoop(angle, length, slope).begin(inputs(0.0, edge), still(edge))
    heel = [0.9, 0.0, 0.0] - length * edge.rotation[:, 0]
    for time in np.linspace(0.0, active.path.duration, 20):
        pose = active.setpoint(inputs(time)).reference.pose
        assert (pose.translation - length * pose.rotation[:, 0])[2] > heel[2] - 0.012
    end = active.path.lines[-1].end
    np.testing.assert_allclose(end.rotation, tool_rotation(0.0, slope - angle), atol=1e-9)
    np.testing.assert_allclose(end.translation - length * end.rotation[:, 0], heel, atol=1e-9)


@pytest.mark.parametrize(
    ("primitive", "rest", "trigger"),
    [
        (Move(0.3 * X, 0.1), 0.5, "end of the line"),
        (Carry(HERE.moved([0.1, 0.2, 0.0]), 0.25, 1.0), 0.3, "arrived"),
        (Scoop(0.8, 0.11, 0.17), 0.2, "tilted back"),
        (Lift(0.2, 0.12, 1.0), 1.0, "lifted"),
    ],
    ids=lambda value: getattr(value, "name", None),
)
def test_a_motion_rests_at_its_end_before_it_ends(primitive, rest, trigger):
    active = primitive.begin(inputs(0.0), still())
    end, duration = active.path.end, active.path.duration
    assert active.ending(inputs(duration + rest - 0.01, end)) is None
    assert active.ending(inputs(duration + rest + 0.01, end)).trigger == trigger


@pytest.mark.parametrize(
    "primitive",
    [Move(0.3 * X, 0.1), Carry(HERE.moved([0.1, 0.2, 0.0]), 0.25, 1.0), Lift(0.2, 0.12, 1.0)],
    ids=lambda primitive: primitive.name,
)
def test_a_motion_fails_that_ends_more_than_five_centimetres_from_its_goal(primitive):
    active = primitive.begin(inputs(0.0), still())
    end, late = active.path.end, active.path.duration + 2.0
    assert not active.ending(inputs(late, end.moved([0.0, 0.0, -0.049]))).failed
    assert active.ending(inputs(late, end.moved([0.0, 0.0, -0.051]))).failed


def test_lift_backs_off_diagonally_before_it_rises():
    pressed = HERE.moved(0.05 * X)
    active = Lift(0.2, 0.12, 1.0, back=-0.06 * X).begin(inputs(0.0), still(pressed))
    away, up = (active.path.lines[k].displacement for k in (0, 1))
    np.testing.assert_allclose(away, [-0.11, 0.0, 0.11], atol=1e-12)
    np.testing.assert_allclose(up, [0.0, 0.0, 0.09], atol=1e-12)


CRATE = Pose([0.55, 0.36, 0.22], tool_rotation(0.57, 0.9))
IN_BIN = Pose([0.9, 0.0, 0.01], tool_rotation(0.0, 0.9))


def test_carry_rises_to_the_height_of_its_goal_before_it_crosses():
    active = Carry(CRATE, 0.25, 1.0).begin(inputs(0.0, IN_BIN), still(IN_BIN))
    up, across = active.path.lines
    assert up.displacement[2] == pytest.approx(0.21)
    assert up.displacement[1] == 0.0
    assert across.displacement[2] == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(active.path.end.translation, CRATE.translation, atol=1e-9)
    np.testing.assert_allclose(active.path.end.rotation, CRATE.rotation, atol=1e-9)


def test_carry_backs_off_from_the_hand_rather_than_from_the_reference():
    active = Carry(CRATE, 0.25, 1.0).begin(inputs(0.0, IN_BIN.moved([-0.02, 0.0, 0.0])), still(IN_BIN))
    assert active.path.lines[0].end.translation[0] == pytest.approx(0.9 - 0.02 - 0.06)


def test_carry_at_the_height_of_its_goal_goes_straight():
    here = IN_BIN.moved([0.0, 0.0, 0.21])
    active = Carry(CRATE, 0.25, 1.0).begin(inputs(0.0, here), still(here))
    assert len(active.path.lines) == 1


def test_release_opens_the_hand_and_stays_in_place():
    active = Release(1.0).begin(inputs(0.0, CRATE), still(CRATE, 1.0))
    setpoint = active.setpoint(inputs(0.4, CRATE))
    assert setpoint.closure == 0.0
    np.testing.assert_array_equal(setpoint.reference.pose.translation, CRATE.translation)
    assert active.ending(inputs(0.9, CRATE)) is None
    assert active.ending(inputs(1.0, CRATE)).trigger == "opened"
