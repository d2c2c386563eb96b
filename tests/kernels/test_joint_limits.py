"""The law of the position limit for one joint: it stops in time, brakes no harder than it can, and is left alone."""

from math import inf, sqrt

import numpy as np
import pytest

from pilegrasp_ctrl.kernels.approach import allowed_speed
from pilegrasp_ctrl.kernels.joint_limits import mean_deceleration, position_bound

PERIOD = 0.002
HORIZON = 2.0 * PERIOD
GAIN, RETREAT, DEMAND, RETREAT_DEMAND = 20.0, 0.3, 4.0, 1.25


def bound(distance, v, now, least, slope=20.0):
    return position_bound(distance, v, now, least, slope, GAIN, RETREAT, HORIZON, DEMAND, RETREAT_DEMAND)


def run_into_limit(distance, v, deceleration, least, duration=4.0):
    """Return distances and accelerations of a joint that obeys its bound, and else accelerates toward the limit.

    `deceleration` is a function of the distance.
    """
    distances, accelerations = [], []
    for _ in range(round(duration / PERIOD)):
        a = min(bound(distance, v, deceleration(distance), least), 5.0)
        distance, v = distance - PERIOD * v - 0.5 * PERIOD**2 * a, v + PERIOD * a
        distances.append(distance)
        accelerations.append(a)
    return np.array(distances), np.array(accelerations)


@pytest.mark.parametrize("braking", [0.2, 1.0, 10.0, 100.0, 1e6])
def test_a_joint_stops_at_its_limit_and_brakes_no_harder_than_it_can(braking):
    distances, accelerations = run_into_limit(1.0, 0.0, lambda _: braking, braking, duration=8.0)
    assert (distances > -1e-4).all()
    assert distances[-1] < 1e-3
    assert accelerations.min() > -1.02 * braking - 0.01


@pytest.mark.parametrize("now", [5.0, 20.0, 50.0])
@pytest.mark.parametrize("start", [0.3, 0.7, 1.5])
def test_a_joint_brakes_in_time_where_gravity_takes_its_torque_on_the_way(now, start):
    """The deceleration that it can hold falls as fast as the law assumes, down to the least."""
    least, slope = 0.5, 20.0

    def deceleration(distance):
        return max(least, now - slope * (start - distance))

    distances, accelerations = run_into_limit(start, 0.0, deceleration, least, duration=8.0)
    assert (distances > -1e-4).all()
    held = np.array([deceleration(distance) for distance in distances])
    assert (accelerations > -1.25 * held).all()


def test_the_acceleration_changes_without_jumps_on_the_way_to_the_limit():
    _, accelerations = run_into_limit(1.0, 1.5, lambda _: 10.0, 10.0)
    braking = accelerations < 0.0
    changes = np.abs(np.diff(accelerations[braking]))
    # The joint meets its bound within a horizon. From then on a jump would be a step of several rad/s².
    assert np.sort(changes)[-8:].max() < 10.0
    assert np.median(changes) < 0.05
    assert (changes[20:] < 1.0).all()


def test_far_from_its_limit_a_joint_may_move_as_fast_as_it_can_stop():
    braking = 8.0
    for distance in (0.3, 0.5, 1.0):
        v = 0.95 * sqrt(2.0 * braking * distance - (braking / GAIN) ** 2)
        assert bound(distance, v, braking, braking) > 0.0
    assert bound(1.0, 1.5, braking, 0.2) > 50.0


def test_the_mean_deceleration_is_the_work_of_braking_over_the_distance():
    now, least, slope = 8.0, 2.0, 12.0
    for distance in (0.1, 0.5, 2.0):
        way = np.linspace(0.0, distance, 100001)
        work = np.trapezoid(np.maximum(now - slope * way, least), way)
        assert mean_deceleration(now, least, slope, distance) == pytest.approx(work / distance, rel=1e-6)
    assert mean_deceleration(now, least, slope, 0.0) == now
    assert mean_deceleration(now, now, 0.0, 1.0) == now


def test_line_and_parabola_of_the_allowed_speed_meet_smoothly():
    braking = 6.0
    knee, step = braking / GAIN**2, 1e-7
    speeds = [allowed_speed(knee + k * step, braking, GAIN, RETREAT) for k in (-1, 0, 1)]
    assert speeds[1] == pytest.approx(braking / GAIN)
    assert (speeds[1] - speeds[0]) / step == pytest.approx((speeds[2] - speeds[1]) / step, rel=1e-3)


def test_a_joint_beyond_its_limit_stops_and_returns_gently():
    least = 4.0
    # At rest, it accelerates toward its range as little as a bound may ask for.
    assert bound(-0.1, 0.0, 50.0, least) == pytest.approx(-RETREAT_DEMAND * least)
    # Where it still moves away, it brakes with what it has.
    assert bound(-0.1, 1.0, 50.0, least) == pytest.approx(-DEMAND * 50.0)
    # It returns no faster than it should.
    assert bound(-0.1, -RETREAT, 50.0, least) == pytest.approx(0.0, abs=1e-9)


def test_a_joint_without_a_limit_is_free():
    assert bound(inf, 5.0, 1.0, 1.0) == inf
