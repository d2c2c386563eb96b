"""Straight lines are smooth, reach their goal, and stay within their speeds and accelerations."""

import numpy as np
import pinocchio as pin
import pytest

from pilegrasp_ctrl.trajectories.speed_profile import SpeedProfile
from pilegrasp_ctrl.trajectories.straight_line import StraightLine
from pilegrasp_ctrl.types import Pose

START = Pose([0.4, -0.1, 0.3], pin.rpy.rpyToMatrix(0.3, -0.5, 1.0))
LINES = {
    "push": StraightLine(START, [0.3, 0.0, 0.0], 0.1),
    "fast": StraightLine(START, [0.0, 0.4, -0.3], 0.5, acceleration=2.0),
    "short": StraightLine(START, [0.0, 0.0, 0.004], 0.5),
    "turning": StraightLine(START, [0.1, 0.0, 0.2], 0.1, rotation=[0.0, 0.6, 0.3]),
    "in place": StraightLine(START, [0.0, 0.0, 0.0], 0.1, rotation=[0.0, 0.0, 1.2], angular_speed=0.4),
}


@pytest.fixture(params=LINES.values(), ids=LINES.keys())
def line(request):
    return request.param


def differentiate(line, time, step=1e-6):
    """Return twist and acceleration at `time` from differences of poses and of twists."""
    before, after = line.at(time - step), line.at(time + step)
    linear = (after.pose.translation - before.pose.translation) / (2 * step)
    angular = pin.log3(after.pose.rotation @ before.pose.rotation.T) / (2 * step)
    return np.concatenate((linear, angular)), (after.twist - before.twist) / (2 * step)


def test_twist_and_acceleration_are_derivatives_of_the_pose(line):
    for time in np.linspace(-0.1, line.duration + 0.1, 41):
        twist, acceleration = differentiate(line, time)
        np.testing.assert_allclose(line.at(time).twist, twist, atol=1e-7)
        np.testing.assert_allclose(line.at(time).acceleration, acceleration, atol=1e-4)


def test_position_velocity_and_acceleration_are_continuous(line):
    times = np.linspace(-0.01, line.duration + 0.01, 2001)
    step = times[1] - times[0]
    references = [line.at(time) for time in times]
    positions = np.array([reference.pose.translation for reference in references])
    twists = np.array([reference.twist for reference in references])
    accelerations = np.array([reference.acceleration for reference in references])
    peak_twist, peak = np.abs(twists).max(), np.abs(accelerations).max()
    jerk = 4.0 * peak / line.profile.ramp
    assert np.abs(np.diff(positions, axis=0)).max() <= peak_twist * step * 1.01
    assert np.abs(np.diff(twists, axis=0)).max() <= peak * step * 1.01
    assert np.abs(np.diff(accelerations, axis=0)).max() <= jerk * step * 1.01


def test_the_reference_rests_at_both_ends_and_outside(line):
    for time in (-1.0, 0.0):
        np.testing.assert_array_equal(line.at(time).pose.translation, START.translation)
        np.testing.assert_array_equal(line.at(time).pose.rotation, START.rotation)
    for time in (line.duration, line.duration + 1.0):
        np.testing.assert_allclose(line.at(time).pose.translation, START.translation + line.displacement, atol=1e-15)
        np.testing.assert_allclose(line.at(time).pose.rotation, line.end.rotation, atol=1e-15)
    for time in (-1.0, 0.0, line.duration, line.duration + 1.0):
        assert not line.at(time).twist.any()
        assert not line.at(time).acceleration.any()


def test_the_tool_turns_by_the_rotation():
    end = LINES["turning"].at(100.0).pose
    np.testing.assert_allclose(pin.log3(end.rotation @ START.rotation.T), [0.0, 0.6, 0.3], atol=1e-12)


def test_the_tool_stays_on_the_line_and_holds_its_orientation():
    line = LINES["fast"]
    for time in np.linspace(0.0, line.duration, 50):
        offset = line.at(time).pose.translation - START.translation
        np.testing.assert_allclose(np.cross(offset, line.displacement), 0.0, atol=1e-15)
        np.testing.assert_array_equal(line.at(time).pose.rotation, START.rotation)


def test_the_speed_is_reached_and_the_duration_is_that_of_length_plus_one_ramp():
    line = StraightLine(START, [0.3, 0.0, 0.0], 0.1, acceleration=0.5)
    assert line.length == pytest.approx(0.3)
    np.testing.assert_allclose(line.at(0.5 * line.duration).twist, [0.1, 0, 0, 0, 0, 0], atol=1e-15)
    assert line.duration == pytest.approx(0.3 / 0.1 + 1.5 * 0.1 / 0.5)


def test_no_limit_is_exceeded():
    line = StraightLine(
        START, [0.1, 0, 0], 0.2, acceleration=0.4, rotation=[0, 0, 1.0], angular_speed=0.5, angular_acceleration=1.0
    )
    references = [line.at(time) for time in np.linspace(0.0, line.duration, 2001)]
    speeds = np.array([np.linalg.norm(r.twist.reshape(2, 3), axis=1) for r in references])
    rises = np.array([np.linalg.norm(r.acceleration.reshape(2, 3), axis=1) for r in references])
    assert (speeds.max(axis=0) <= [0.2 + 1e-12, 0.5 + 1e-12]).all()
    assert (rises.max(axis=0) <= [0.4 + 1e-12, 1.0 + 1e-12]).all()
    assert speeds[:, 1].max() == pytest.approx(0.5)


def test_a_short_path_lowers_the_speed_and_keeps_the_acceleration():
    profile = SpeedProfile(length=0.004, speed=0.5, acceleration=0.5)
    accelerations = [profile.at(time)[2] for time in np.linspace(0.0, profile.duration, 2001)]
    assert profile.peak_speed < 0.05
    assert max(accelerations) == pytest.approx(0.5, rel=1e-3)
    assert profile.at(0.5 * profile.duration)[:2] == pytest.approx((0.002, profile.peak_speed))


def test_a_line_of_zero_length_takes_no_time():
    line = StraightLine(START, [0.0, 0.0, 0.0], 0.1)
    assert line.duration == 0.0
    np.testing.assert_array_equal(line.at(0.0).pose.translation, START.translation)
    assert not line.at(0.0).twist.any()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"speed": 0.0}, "speed = 0"),
        ({"speed": -0.1}, "speed = -0.1"),
        ({"speed": np.inf}, "speed = inf"),
        ({"speed": np.nan}, "speed = nan"),
        ({"acceleration": 0.0}, "acceleration = 0"),
        ({"angular_speed": 0.0, "rotation": [0, 0, 1]}, "angular_speed = 0"),
        ({"displacement": [0.1, 0.0]}, "displacement"),
        ({"displacement": [0.1, np.nan, 0.0]}, "displacement.*not finite"),
        ({"rotation": [np.inf, 0, 0]}, "rotation.*not finite"),
    ],
)
def test_a_motion_that_cannot_be_planned_is_rejected(arguments, message):
    with pytest.raises(ValueError, match=message):
        StraightLine(**{"start": START, "displacement": [0.1, 0.0, 0.0], "speed": 0.1, **arguments})
