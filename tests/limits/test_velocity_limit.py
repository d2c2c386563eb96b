"""The velocity limit keeps the speeds of the joints within the arm's."""

import numpy as np
import pytest

from arms import ARMS, load, random_states, without_friction
from pilegrasp_ctrl.exceptions import ArgumentError, ConfigurationError
from pilegrasp_ctrl.limits.braking import braking_acceleration
from pilegrasp_ctrl.limits.motion_limits import VelocityLimit

RATE = 500.0


@pytest.fixture(params=ARMS)
def arm(request):
    return load(request.param)


def test_the_bound_ends_at_the_limit_after_its_horizon(arm):
    limit = VelocityLimit(arm, RATE, margin=0.0)
    q, v = next(random_states(arm, 1))
    bounds = limit.rows(arm.update(q, v))
    assert limit.horizon == pytest.approx(2.0 / RATE)
    np.testing.assert_allclose(v + limit.horizon * bounds.upper, arm.velocity_limit, atol=1e-12)
    np.testing.assert_allclose(v + limit.horizon * bounds.lower, -arm.velocity_limit, atol=1e-12)
    assert bounds.names[2] == "velocity[2]"


def test_a_joint_that_is_found_too_fast_slows_down_within_its_braking(arm):
    limit, braking = VelocityLimit(arm, RATE), braking_acceleration(arm)
    q = 0.5 * (arm.q_lower + arm.q_upper)
    np.testing.assert_allclose(limit.rows(arm.update(q, 50.0 * arm.velocity_limit)).upper, -1.25 * braking)
    np.testing.assert_allclose(limit.rows(arm.update(q, -50.0 * arm.velocity_limit)).lower, 1.25 * braking)


def test_a_joint_without_a_velocity_limit_is_free():
    speed = np.array([2.0, np.inf, 2.0, 2.0, 2.0, 2.0, np.inf])
    arm = without_friction("panda", velocity_limit=speed)
    bounds = VelocityLimit(arm, RATE).rows(arm.update(np.zeros(7), np.full(7, 5.0)))
    assert (np.isinf(bounds.upper) == np.isinf(speed)).all()


@pytest.mark.parametrize(
    "arguments", [{"rate": 0.0}, {"rate": np.inf}, {"margin": 1.0}, {"margin": -0.1}, {"horizon_periods": 0.0}]
)
def test_a_number_out_of_range_is_refused_by_name(arguments):
    with pytest.raises(ConfigurationError, match=next(iter(arguments))):
        VelocityLimit(load("panda"), **arguments)


def test_what_is_no_arm_is_refused():
    with pytest.raises(ArgumentError, match="VelocityLimit takes the arm"):
        VelocityLimit("panda")
