"""Joint friction: how much the feed-forward compensates, how much it leaves, and when it does harm."""

import numpy as np
import pytest

from arms import ARMS, HAND, HOME, load, with_friction, without_friction
from pilegrasp_ctrl.control.friction_compensation import FrictionCompensation
from pilegrasp_ctrl.control.operational_space import OperationalSpaceController
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.plant.arm_simulation import ArmSimulation
from pilegrasp_ctrl.plant.tracking import simulate_tracking
from pilegrasp_ctrl.trajectories.straight_line import StraightLine
from pilegrasp_ctrl.tuning.stability_margin import LateController
from pilegrasp_ctrl.types import Observation, Reference


def plant(arm, factor=1.0):
    return ArmSimulation(
        arm, friction_coulomb=factor * arm.friction_coulomb, friction_viscous=factor * arm.friction_viscous
    )


def lengths(motion):
    """Return position error [m] and orientation error [rad] in each period."""
    return np.linalg.norm(motion.error[:, :3], axis=1), np.linalg.norm(motion.error[:, 3:], axis=1)


def test_friction_is_compensated_within_a_millimetre_and_not_without_the_feed_forward():
    arm, q = with_friction("wam7", tool=HAND), HOME["wam7"]
    line = StraightLine(arm.update(q, np.zeros(7)).pose, [0.0, 0.1, 0.0], 0.1)
    place, turn = {}, {}
    for on in (True, False):
        controller = OperationalSpaceController(arm, posture=q, friction=on)
        place[on], turn[on] = lengths(simulate_tracking(plant(arm), controller, line.at, q, line.duration + 0.1))
    assert place[True].max() < 2e-3
    assert np.sqrt(np.mean(place[True] ** 2)) < 1e-3
    assert turn[True].max() < np.radians(0.5)
    assert np.mean(place[False] ** 2) > 9.0 * np.mean(place[True] ** 2)
    assert turn[False].max() > 3.0 * turn[True].max()


@pytest.mark.slow
@pytest.mark.parametrize(("factor", "rms", "rest"), [(0.7, 1.3e-3, 0.8e-3), (1.0, 0.5e-3, 1.2e-3), (1.3, 3.5e-3, 6e-3)])
@pytest.mark.parametrize("name", ARMS)
def test_friction_that_differs_from_the_model_costs_millimetres(name, factor, rms, rest):
    """With too little friction in the model, the arm stops short of its goal; with too much, it overshoots less far."""
    arm, q = with_friction(name), HOME[name]
    line = StraightLine(arm.update(q, np.zeros(7)).pose, [0.0, 0.15, 0.05], 0.1)
    motion = simulate_tracking(
        plant(arm, factor), OperationalSpaceController(arm, posture=q), line.at, q, line.duration + 1.0
    )
    place, _ = lengths(motion)
    assert np.sqrt(np.mean(place[motion.time < line.duration] ** 2)) < rms
    assert place[-1] < rest
    # The arm rests there, without creep or a limit cycle.
    assert np.ptp(motion.error[-100:], axis=0).max() < 2e-5


@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_friction_is_compensated_when_the_motion_reverses(name):
    """The feed-forward reverses with the reference, not after the sensors measure the reversal."""
    arm, q = with_friction(name), HOME[name]
    start, swing = arm.update(q, np.zeros(7)).pose, 2.0 * np.pi * 0.5

    def at(time):
        amplitude = np.array([0.0, 0.04, 0.02])
        twist, acceleration = np.zeros(6), np.zeros(6)
        twist[:3] = amplitude * swing * np.sin(swing * time)
        acceleration[:3] = amplitude * swing**2 * np.cos(swing * time)
        return Reference(start.moved(amplitude * (1.0 - np.cos(swing * time))), twist, acceleration)

    largest = {}
    for on in (True, False):
        motion = simulate_tracking(plant(arm), OperationalSpaceController(arm, posture=q, friction=on), at, q, 4.0)
        largest[on] = lengths(motion)[0][motion.time > 1.0].max()
    assert largest[True] < 1.2e-3
    assert largest[False] > 4.0 * largest[True]


def swing_at_rest(name, gain, late):
    """Return the range of the tool's error in the last half second of a rest after a line [m, rad]."""
    arm, q = with_friction(name), HOME[name]
    line = StraightLine(arm.update(q, np.zeros(7)).pose, [0.0, 0.1, 0.05], 0.15)
    controller = OperationalSpaceController(arm, posture=q, friction=FrictionCompensation(arm, gain=gain))
    motion = simulate_tracking(plant(arm), LateController(controller, late), line.at, q, line.duration + 2.0)
    return np.ptp(motion.error[-250:], axis=0).max()


@pytest.mark.slow
@pytest.mark.parametrize("late", [0, 1, 2])
@pytest.mark.parametrize("gain", [1.0, 2.0])
@pytest.mark.parametrize("name", ARMS)
def test_the_arm_comes_to_rest_with_the_true_and_with_twice_the_true_friction(name, gain, late):
    assert swing_at_rest(name, gain, late) < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "gain", "late"), [("wam7", 3.0, 1), ("panda", 5.0, 1), ("wam7", 10.0, 0), ("panda", 15.0, 0)]
)
def test_gross_overcompensation_ends_in_a_limit_cycle(name, gain, late):
    """The part from the error is a stiff spring without damper; true friction steadies it up to some gain and delay."""
    assert swing_at_rest(name, gain, late) > 1e-3


def test_the_friction_feed_forward_is_within_the_torque_limits():
    name = "wam7"
    weak = load(name)
    arm = without_friction(
        name, torque_limit=[8.0, 25.0, 5.0, 6.0, 1.0, 1.0, 0.3], friction_coulomb=weak.friction_coulomb
    )
    controller = OperationalSpaceController(arm, posture=HOME[name])
    q, v = HOME[name], np.zeros(7)
    reference = Reference(arm.update(q, v).pose.moved([0.0, 0.2, 0.0]), np.array([0, 0.3, 0, 0, 0, 0]))
    output = controller.step(Observation(0.0, q, v), reference)
    assert any(name.startswith("torque") for name in output.active_limits)
    assert (np.abs(output.command.torque) <= arm.torque_limit).all()


def feed_forward(arm, compensation, v, twist, displacement=(0.0, 0.0, 0.0)):
    q = HOME[arm.name]
    observation, pose = Observation(0.0, q, v), arm.update(q, 0.0 * q).pose
    reference = Reference(pose.moved(displacement), twist)
    compensated, plain = (
        OperationalSpaceController(arm, limits=(), friction=friction).step(observation, reference).command.torque
        for friction in (compensation, False)
    )
    return compensated - plain


@pytest.mark.parametrize("name", ARMS)
def test_friction_is_fed_forward_by_the_reference_not_by_the_measured_velocity(name):
    arm = with_friction(name)
    compensation, twist = FrictionCompensation(arm, scale=1e-3), np.array([0.0, 0.1, 0.0, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(feed_forward(arm, compensation, 0.1 * np.ones(7), np.zeros(6)), 0.0, atol=1e-9)
    wanted = np.linalg.pinv(arm.update(HOME[name], np.zeros(7)).J) @ twist
    expected = arm.friction_coulomb * np.tanh(wanted / 1e-3) + arm.friction_viscous * wanted
    np.testing.assert_allclose(feed_forward(arm, compensation, np.zeros(7), twist), expected, atol=0.03)
    less = FrictionCompensation(arm, scale=1e-3, gain=0.7)
    np.testing.assert_allclose(feed_forward(arm, less, np.zeros(7), twist), 0.7 * expected, atol=0.03)


@pytest.mark.parametrize("name", ARMS)
def test_for_a_distant_goal_the_friction_at_0_1_m_per_s_is_compensated(name):
    arm, direction = with_friction(name), np.array([0.0, 0.6, 0.8])
    slow = np.concatenate((0.1 * direction, np.zeros(3)))
    expected = feed_forward(arm, True, np.zeros(7), slow)
    for distance in (0.05, 0.5):
        given = feed_forward(arm, True, np.zeros(7), np.zeros(6), distance * direction)
        np.testing.assert_allclose(given, expected, atol=1e-9)
    near = feed_forward(arm, True, np.zeros(7), np.zeros(6), 0.01 * direction)
    np.testing.assert_allclose(near, feed_forward(arm, True, np.zeros(7), 0.8 * slow), atol=1e-9)


def test_an_arm_without_friction_gets_no_feed_forward():
    arm = without_friction("panda")
    torque = feed_forward(arm, True, np.zeros(7), np.array([0.0, 0.1, 0.0, 0.0, 0.0, 0.0]))
    np.testing.assert_array_equal(torque, 0.0)


@pytest.mark.parametrize(
    "argument", [{"scale": 0.0}, {"scale": np.nan}, {"error_rate": -1.0}, {"gain": -0.1}, {"gain": np.inf}]
)
def test_unusable_numbers_are_rejected(argument):
    with pytest.raises(ConfigurationError, match=next(iter(argument))):
        FrictionCompensation(load("wam7"), **argument)
