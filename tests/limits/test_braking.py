"""How hard the joints of an arm can brake, and which of them cannot."""

import warnings

import numpy as np
import pytest

import pilegrasp_ctrl as pg
from arms import ARMS, load, random_states, without_friction
from pilegrasp_ctrl.exceptions import BrakingWarning, ConfigurationError
from pilegrasp_ctrl.kernels.joint_limits import spare_torque
from pilegrasp_ctrl.limits.braking import MIN_BRAKING, braking_acceleration
from pilegrasp_ctrl.limits.torque_limit import TorqueLimit
from pilegrasp_ctrl.types import MassProperties


@pytest.fixture(params=ARMS)
def arm(request):
    return load(request.param)


def with_load(mass):
    return load("panda", tool=MassProperties(mass, np.zeros(3), 1e-3 * mass * np.eye(3)))


def spare_torques(arm, h):
    limit, spare = TorqueLimit(arm), np.empty((2, arm.nv))
    spare_torque(limit.S, limit.limit, h, spare)
    return spare


def test_the_spare_torque_of_a_joint_takes_it_exactly_to_a_limit(arm):
    limit, rng = TorqueLimit(arm), np.random.default_rng(2)
    for _ in range(20):
        h = rng.uniform(-0.5, 0.5, arm.nv) * arm.torque_limit
        for sign, spare in zip((1.0, -1.0), spare_torques(arm, h), strict=True):
            for joint in range(arm.nv):
                torque = h.copy()
                torque[joint] += sign * spare[joint]
                assert np.max(np.abs(limit.S @ torque) / limit.limit) == pytest.approx(1.0)


def test_without_shared_motors_the_spare_torque_is_the_limit_beside_the_torque():
    arm, h = load("panda"), np.linspace(-5.0, 5.0, 7)
    np.testing.assert_allclose(spare_torques(arm, h), [arm.torque_limit - h, arm.torque_limit + h])


def test_the_braking_acceleration_is_within_the_torque_of_every_joint(arm):
    braking = braking_acceleration(arm)
    assert (braking > 0.0).all()
    np.testing.assert_array_equal(braking, braking_acceleration(arm))
    for q, _ in random_states(arm, 50, seed=3):
        state = arm.update(q, np.zeros(arm.nv))
        needed = braking * state.M.diagonal() + np.abs(state.h)
        assert (needed <= arm.torque_limit).all()


def test_a_joint_brakes_with_half_of_the_torque_left_in_the_worst_posture(arm):
    """The other half is for coupling with other joints and for a load in the hand."""
    braking = braking_acceleration(arm)
    spare_acceleration = np.full(arm.nv, np.inf)
    for q, _ in random_states(arm, 300, seed=5):
        state = arm.update(q, np.zeros(arm.nv))
        spare = spare_torques(arm, state.h).min(axis=0) - arm.friction_coulomb
        spare_acceleration = np.minimum(spare_acceleration, spare / state.M.diagonal())
    # These postures differ from the function's, so their worst case is slightly milder.
    np.testing.assert_allclose(braking / spare_acceleration, 0.5, rtol=0.1)


def test_a_placeholder_for_the_velocity_limit_does_not_change_how_hard_a_joint_brakes():
    stated = braking_acceleration(load("panda"))
    for speed in (100.0, 1e4, np.inf):
        placeholder = without_friction("panda", velocity_limit=np.full(7, speed))
        np.testing.assert_array_equal(braking_acceleration(placeholder), stated)


def test_an_arm_that_can_brake_everywhere_makes_its_limits_without_a_warning(arm):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pg.limits_of(arm)


@pytest.mark.parametrize(
    ("change", "joint"),
    [
        ({"torque_limit": np.array([87.0, 5.0, 87.0, 87.0, 12.0, 12.0, 12.0])}, "panda_joint2"),
        ({"torque_limit": np.array([87.0, 87.0, 87.0, 1.0, 12.0, 12.0, 12.0])}, "panda_joint4"),
    ],
)
def test_a_joint_that_gravity_leaves_no_torque_to_brake_is_named_when_the_controller_is_made(change, joint):
    weak = without_friction("panda", **change)
    with pytest.raises(ConfigurationError, match=f"'{joint}' cannot brake"):
        pg.OperationalSpaceController(weak)
    pg.OperationalSpaceController(weak, limits=["torque", "velocity"])


def test_a_load_that_no_wrist_can_carry_is_refused_with_the_name_of_the_joint():
    with pytest.raises(ConfigurationError, match=r"'panda_joint6' cannot brake in .* of its postures"):
        pg.OperationalSpaceController(with_load(12.0))


def test_a_joint_that_is_too_weak_in_some_postures_is_named_in_a_warning():
    with pytest.warns(BrakingWarning, match="'panda_joint2' cannot brake in 3% of its postures"):
        pg.OperationalSpaceController(with_load(4.0))
    assert braking_acceleration(with_load(4.0))[1] == MIN_BRAKING
