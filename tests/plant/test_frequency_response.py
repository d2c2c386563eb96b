"""The measured gain and phase of a closed loop are those of its transfer function."""

import numpy as np
import pytest

from arms import ARMS, HOME, load, without_friction
from pilegrasp_ctrl import (
    ArmSimulation,
    FrequencyResponse,
    MotionGains,
    OperationalSpaceController,
    frequency_response,
)
from pilegrasp_ctrl.exceptions import ConfigurationError

RATE = 1000.0
STIFFNESS = 400.0
FREQUENCIES = [1.5, 3.1, 10.0]


@pytest.fixture(params=ARMS)
def arm(request):
    return without_friction(request.param)


def controller(arm, ratio=1.0):
    return OperationalSpaceController(arm, MotionGains(STIFFNESS, ratio), posture=HOME[arm.name], rate=RATE)


def textbook(frequency, ratio):
    s = 2j * np.pi * np.asarray(frequency)
    return STIFFNESS / (s * s + 2.0 * ratio * np.sqrt(STIFFNESS) * s + STIFFNESS)


@pytest.mark.slow
@pytest.mark.parametrize(("ratio", "axis"), [(0.5, 2), (1.0, 4)])
def test_the_operational_space_loop_is_its_transfer_function(arm, ratio, axis):
    response = frequency_response(arm, controller(arm, ratio), HOME[arm.name], axis, FREQUENCIES, rate=RATE)
    expected = textbook(FREQUENCIES, ratio)
    np.testing.assert_allclose(response.gain, np.abs(expected), rtol=0.02)
    # A torque that is held for a period is half a period late: 0.03 rad at 10 Hz and 1 kHz.
    np.testing.assert_allclose(response.phase, np.angle(expected), atol=0.04)
    assert (response.distortion < 1e-3).all()
    assert response.active_limits == ()


@pytest.mark.slow
def test_feed_forward_of_velocity_and_acceleration_removes_the_lag(arm):
    response = frequency_response(
        arm, controller(arm), HOME[arm.name], 2, [1.0, 3.1], feedforward=True, rate=RATE, amplitude=0.002
    )
    np.testing.assert_allclose(response.gain, 1.0, atol=0.01)
    np.testing.assert_allclose(response.phase, 0.0, atol=0.02)


def of(gain, frequency=(1.0, 2.0, 4.0, 8.0)):
    ones = np.ones(4)
    return FrequencyResponse(np.array(frequency), np.array(gain), -ones, 0.0 * ones, 0.01, (), 0)


def test_the_bandwidth_is_the_frequency_at_minus_three_decibels():
    assert of(10.0 ** (-np.array([0.0, 2.0, 4.0, 9.0]) / 20.0)).bandwidth == pytest.approx(np.sqrt(8.0))
    assert of([1.0, 0.9, 0.9, 0.8]).bandwidth == np.inf
    assert of([0.6, 0.9, 0.9, 0.8]).bandwidth == 0.0


def test_the_resonance_is_the_largest_gain():
    response = of([1.0, 1.3, 0.9, 0.1])
    assert (response.resonance_peak, response.resonance_frequency) == (1.3, 2.0)


@pytest.mark.slow
def test_the_bandwidth_of_a_critically_damped_loop_is_that_of_the_textbook():
    """The textbook's condition is (1 + r²)² = 2 with r = ω / √K."""
    arm = without_friction("panda")
    response = frequency_response(arm, controller(arm), HOME["panda"], 0, [1.5, 2.0, 2.5], rate=RATE)
    assert response.bandwidth == pytest.approx(np.sqrt(STIFFNESS * (np.sqrt(2.0) - 1.0)) / (2.0 * np.pi), rel=0.02)


def test_frequencies_are_sorted_and_the_default_amplitude_is_small():
    arm = without_friction("panda")
    response = frequency_response(arm, controller(arm), HOME["panda"], 5, [5.0, 2.0], rate=RATE, periods=1)
    np.testing.assert_array_equal(response.frequency, [2.0, 5.0])
    assert response.gain[0] > response.gain[1]
    assert response.amplitude == 0.02


@pytest.mark.slow
def test_friction_distorts_a_large_oscillation_less_than_a_small_one():
    arm, q = load("wam7"), HOME["wam7"]
    loop = OperationalSpaceController(arm, posture=q, friction=False)
    small, large = (frequency_response(arm, loop, q, 1, [1.0], amplitude=size, periods=2) for size in (0.01, 0.04))
    none = frequency_response(
        arm, loop, q, 1, [1.0], periods=2, simulation=ArmSimulation(arm, friction_coulomb=0.0, friction_viscous=0.0)
    )
    assert none.distortion[0] < 1e-3 < large.distortion[0] < small.distortion[0]
    assert small.gain[0] < large.gain[0] < none.gain[0]


def test_active_limits_are_named():
    arm = without_friction("panda")
    response = frequency_response(
        arm, controller(arm), HOME["panda"], 1, [10.0], amplitude=0.03, feedforward=True, rate=RATE
    )
    assert response.active_limits
    assert response.distortion[0] > 1e-3


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"axis": 6}, "axis = 6"),
        ({"frequencies": []}, "frequencies"),
        ({"frequencies": [0.0, 1.0]}, "frequencies"),
        ({"frequencies": [300.0]}, "at most a quarter of the rate, 250 Hz"),
        ({"amplitude": 0.0}, "amplitude = 0"),
        ({"periods": 0}, "periods = 0"),
    ],
)
def test_an_oscillation_that_cannot_be_made_is_rejected(arguments, message):
    arm = without_friction("panda")
    with pytest.raises(ConfigurationError, match=message):
        frequency_response(arm, controller(arm), HOME["panda"], **{"rate": RATE, **arguments})
