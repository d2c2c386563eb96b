"""An arc is smooth, keeps its geometry, and stays within its speeds and accelerations."""

import numpy as np
import pinocchio as pin
import pytest

from pilegrasp_ctrl import Arc
from pilegrasp_ctrl.types import Pose

START = Pose([0.4, -0.1, 0.3], pin.rpy.rpyToMatrix(0.3, -0.5, 1.0))
ARCS = {
    "half": Arc(START, [0.4, 0.0, 0.3], [1.0, 0.0, 0.0], np.pi, 0.1),
    "back": Arc(START, [0.4, 0.0, 0.3], [1.0, 0.0, 0.0], -0.5 * np.pi, 0.25),
    "turning": Arc(START, [0.3, 0.0, 0.1], [0.2, -0.4, 1.0], 1.2, 0.1, turning=True),
    "turning slowly": Arc(START, [0.4, -0.05, 0.3], [0.0, 0.0, 2.0], 3.0, 0.5, turning=True, angular_speed=0.4),
    "more than a circle": Arc(START, [0.3, 0.0, 0.3], [0.0, 0.0, 1.0], 7.0, 0.3),
    "short": Arc(START, [0.0, 0.0, 0.3], [0.0, 1.0, 0.0], 0.01, 0.5),
}


@pytest.fixture(params=ARCS.values(), ids=ARCS.keys())
def arc(request):
    return request.param


def test_twist_and_acceleration_are_derivatives_of_the_pose(arc):
    step = 1e-6
    for time in np.linspace(-0.1, arc.duration + 0.1, 41):
        before, now, after = (arc.at(t) for t in (time - step, time, time + step))
        linear = (after.pose.translation - before.pose.translation) / (2 * step)
        angular = pin.log3(after.pose.rotation @ before.pose.rotation.T) / (2 * step)
        np.testing.assert_allclose(now.twist, np.concatenate((linear, angular)), atol=1e-7)
        np.testing.assert_allclose(now.acceleration, (after.twist - before.twist) / (2 * step), atol=1e-4)


@pytest.mark.slow
def test_the_acceleration_is_continuous(arc):
    times = np.linspace(-0.01, arc.duration + 0.01, 4001)
    accelerations = np.array([arc.at(time).acceleration for time in times])
    step = times[1] - times[0]
    # The jerk comes from the ramps and from the centripetal acceleration, which turns and grows with the speed.
    speed, rise = arc.profile.peak_speed * abs(arc.angle), 1.5 * arc.profile.peak_speed / arc.profile.ramp
    rise *= abs(arc.angle)
    jerk = 4.0 * rise / arc.profile.ramp + 3.0 * speed * rise + speed**3
    assert np.linalg.norm(np.diff(accelerations, axis=0), axis=1).max() <= np.hypot(arc.radius, 1.0) * jerk * step


def test_the_tool_keeps_its_distance_from_the_axis_and_its_height_along_it(arc):
    for time in np.linspace(0.0, arc.duration, 30):
        offset = arc.at(time).pose.translation - arc.center
        assert np.linalg.norm(offset) == pytest.approx(arc.radius)
        assert offset @ arc.axis == pytest.approx(0.0, abs=1e-12)


def test_the_reference_rests_at_both_ends_and_outside(arc):
    for time, pose in ((-1.0, START), (0.0, START), (arc.duration, arc.end), (arc.duration + 1.0, arc.end)):
        reference = arc.at(time)
        np.testing.assert_allclose(reference.pose.translation, pose.translation, atol=1e-12)
        np.testing.assert_allclose(reference.pose.rotation, pose.rotation, atol=1e-12)
        assert not reference.twist.any()
        assert not reference.acceleration.any()


def test_half_a_circle_ends_on_the_other_side_with_the_same_orientation():
    end = ARCS["half"].end
    np.testing.assert_allclose(end.translation, [0.4, 0.1, 0.3], atol=1e-12)
    np.testing.assert_array_equal(end.rotation, START.rotation)


def test_a_positive_angle_is_right_handed_and_a_negative_one_left_handed():
    # The tool starts at -y of the centre, so a right-handed turn about x moves it down first.
    assert ARCS["half"].at(0.5 * ARCS["half"].duration).pose.translation[2] == pytest.approx(0.2)
    assert ARCS["back"].end.translation[2] == pytest.approx(0.4)


def test_a_turning_tool_keeps_its_orientation_to_the_axis():
    arc = ARCS["turning"]
    before = START.rotation.T @ (START.translation - arc.center)
    for time in np.linspace(0.0, arc.duration, 10):
        pose = arc.at(time).pose
        np.testing.assert_allclose(pose.rotation.T @ (pose.translation - arc.center), before, atol=1e-12)


def test_the_speed_along_the_arc_is_reached_and_not_exceeded():
    arc = ARCS["half"]
    speeds = [np.linalg.norm(arc.at(time).twist[:3]) for time in np.linspace(0.0, arc.duration, 501)]
    assert max(speeds) == pytest.approx(0.1)
    assert arc.length == pytest.approx(np.pi * 0.1)
    assert arc.duration == pytest.approx(arc.length / 0.1 + 1.5 * 0.1 / 0.5)


def test_a_tool_that_turns_keeps_within_its_angular_speed():
    arc = ARCS["turning slowly"]
    assert max(np.linalg.norm(arc.at(t).twist[3:]) for t in np.linspace(0.0, arc.duration, 501)) == pytest.approx(0.4)


def test_an_arc_of_zero_angle_takes_no_time():
    arc = Arc(START, [0.0, 0.0, 0.0], [0.0, 0.0, 1.0], 0.0, 0.1)
    assert arc.duration == 0.0
    np.testing.assert_allclose(arc.at(1.0).pose.translation, START.translation, atol=1e-15)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"speed": 0.0}, "speed = 0"),
        ({"speed": np.nan}, "speed = nan"),
        ({"acceleration": -1.0}, "acceleration = -1"),
        ({"angular_speed": 0.0}, "angular_speed = 0"),
        ({"angle": np.inf}, "angle = inf"),
        ({"axis": [0.0, 0.0, 0.0]}, "axis of the arc is zero"),
        ({"axis": [0.0, 1.0]}, "axis"),
        ({"center": [0.0, np.nan, 0.0]}, "center.*not finite"),
        ({"center": START.translation, "axis": [0.0, 0.0, 1.0]}, "lies on the axis"),
    ],
)
def test_an_arc_that_cannot_be_planned_is_rejected(arguments, message):
    with pytest.raises(ValueError, match=message):
        Arc(**{"start": START, "center": [0.0, 0.0, 0.0], "axis": [0, 0, 1.0], "angle": 1.0, "speed": 0.1, **arguments})
