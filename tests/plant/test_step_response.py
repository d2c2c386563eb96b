"""The measured step response of a closed loop is that of a second-order system."""

import numpy as np
import pytest

from arms import ARMS, HOME, load, without_friction
from pilegrasp_ctrl import (
    ArmSimulation,
    Impedance,
    ImpedanceController,
    MotionGains,
    OperationalSpaceController,
    step_response,
)
from pilegrasp_ctrl.exceptions import ConfigurationError, ModelError
from pilegrasp_ctrl.tasks.posture_task import PostureTask

RATE = 1000.0
STIFFNESS = 400.0


@pytest.fixture(params=ARMS)
def arm(request):
    return without_friction(request.param)


def controller(arm, ratio=1.0, stiffness=STIFFNESS):
    return OperationalSpaceController(arm, MotionGains(stiffness, ratio), posture=HOME[arm.name], rate=RATE)


def textbook(time, ratio):
    """Return error over step of a unit mass on spring and damper that starts at rest."""
    w = np.sqrt(STIFFNESS)
    if ratio == 1.0:
        return (1.0 + w * time) * np.exp(-w * time)
    damped = w * np.sqrt(1.0 - ratio**2)
    decay = np.exp(-ratio * w * time)
    return decay * (np.cos(damped * time) + ratio * w / damped * np.sin(damped * time))


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [0.5, 1.0])
@pytest.mark.parametrize(
    "step",
    [{"displacement": (0.005, 0.0, 0.0)}, {"displacement": (0.0, 0.0, 0.0), "rotation": (0.0, 0.05, 0.0)}],
    ids=["shift", "turn"],
)
def test_the_operational_space_loop_is_the_second_order_system_of_the_textbook(arm, ratio, step):
    """The held torque acts half a period late, which reduces the damping by K T / 2: 1 % at 1 kHz."""
    response = step_response(arm, controller(arm, ratio), HOME[arm.name], rate=RATE, **step)
    size = np.linalg.norm(response.step)
    along = response.error @ response.step / size**2
    np.testing.assert_allclose(along, textbook(response.time, ratio), atol=0.01)
    fine = np.linspace(0.0, 1.0, 100001)
    error = textbook(fine, ratio)
    assert response.settling_time == pytest.approx(fine[np.flatnonzero(np.abs(error) > 0.02)[-1]], rel=0.03)
    rise = fine[np.argmax(error < 0.1)] - fine[np.argmax(error < 0.9)]
    assert response.rise_time == pytest.approx(rise, rel=0.02)
    overshoot = np.exp(-np.pi * ratio / np.sqrt(1.0 - ratio**2)) if ratio < 1.0 else 0.0
    assert response.overshoot == pytest.approx(overshoot, abs=5e-3)
    assert max(response.steady_state_error) < 1e-3 * size
    assert response.active_limits == ()


def test_twice_the_step_is_twice_the_response(arm):
    small, large = (
        step_response(arm, controller(arm), HOME[arm.name], displacement=(0.0, size, 0.0), rate=RATE)
        for size in (0.005, 0.01)
    )
    np.testing.assert_allclose(2.0 * small.error[:, 1], large.error[:, 1], atol=2e-5)


def test_without_friction_the_steady_state_is_within_a_tenth_of_a_millimetre(arm):
    response = step_response(arm, OperationalSpaceController(arm, posture=HOME[arm.name]), HOME[arm.name])
    assert response.steady_state_error[0] < 1e-4
    assert response.steady_state_error[1] < 1e-4


def test_a_payload_lowers_the_tool_by_its_weight_over_inertia_and_gain(arm):
    """At rest K e = J M⁻¹ Jᵀ weight. The payload is light, so that the arm keeps the posture of this formula."""
    q, weight = HOME[arm.name], np.array([0.0, 0.0, 0.05 * 9.81, 0.0, 0.0, 0.0])
    loop = OperationalSpaceController(arm, MotionGains(STIFFNESS), PostureTask(arm, q, weight=1e-8), rate=RATE)
    loaded = ArmSimulation(arm, payload=0.05)
    response = step_response(arm, loop, q, displacement=(0.001, 0.0, 0.0), rate=RATE, duration=2.0, simulation=loaded)
    state = arm.update(q, np.zeros(arm.nv))
    sag = state.J @ np.linalg.solve(state.M, state.J.T @ weight) / STIFFNESS
    np.testing.assert_allclose(response.steady_state_error[0], np.linalg.norm(sag[:3]), rtol=0.03)
    np.testing.assert_allclose(response.error[-1], sag, atol=0.03 * np.linalg.norm(sag))
    assert response.settling_time == np.inf


@pytest.mark.slow
def test_active_limits_change_the_response_and_are_named(arm):
    small, large = (
        step_response(arm, controller(arm), HOME[arm.name], displacement=(0.0, size, 0.0), rate=RATE, duration=2.0)
        for size in (0.005, 0.4)
    )
    assert small.active_limits == ()
    assert any(name.startswith(("torque", "motor", "velocity")) for name in large.active_limits)
    assert large.rise_time > 1.1 * small.rise_time
    assert small.torque_share < large.torque_share <= 1.0 + 1e-9


def test_a_response_that_does_not_arrive_has_infinite_rise_and_settling_times(arm):
    short = step_response(arm, controller(arm), HOME[arm.name], duration=0.05, rate=RATE)
    assert short.rise_time == short.settling_time == np.inf
    assert short.overshoot == 0.0
    barely = step_response(arm, controller(arm), HOME[arm.name], duration=0.004, rate=RATE)
    assert barely.rise_time == np.inf


def test_the_worse_part_counts_for_a_step_in_position_and_orientation(arm):
    gains = MotionGains([400.0] * 3 + [100.0] * 3)
    loop = OperationalSpaceController(arm, gains, posture=HOME[arm.name], rate=RATE)
    both = step_response(
        arm, loop, HOME[arm.name], displacement=(0.0, 0.0, 0.005), rotation=(0.0, 0.0, 0.02), rate=RATE
    )
    turn = step_response(arm, loop, HOME[arm.name], displacement=(0.0, 0.0, 0.0), rotation=(0.0, 0.0, 0.02), rate=RATE)
    assert both.settling_time == pytest.approx(turn.settling_time, rel=0.02)
    assert both.rise_time == pytest.approx(turn.rise_time, rel=0.02)


def test_an_impedance_controller_has_a_step_response_too(arm):
    impedance = ImpedanceController(arm, Impedance([400.0] * 3 + [30.0] * 3), HOME[arm.name], rate=RATE)
    response = step_response(arm, impedance, HOME[arm.name], displacement=(0.0, 0.0, 0.005), rate=RATE)
    assert response.settling_time < 1.0
    assert response.overshoot < 0.05


def test_joint_friction_leaves_a_steady_state_error():
    arm, q = load("wam7"), HOME["wam7"]
    compensated, plain = (
        step_response(arm, OperationalSpaceController(arm, posture=q, friction=on), q) for on in (True, False)
    )
    ideal = step_response(
        arm,
        OperationalSpaceController(arm, posture=q, friction=False),
        q,
        simulation=ArmSimulation(arm, friction_coulomb=0.0, friction_viscous=0.0),
    )
    assert ideal.steady_state_error[0] < 1e-4 < compensated.steady_state_error[0] < plain.steady_state_error[0]


def test_the_arrays_have_one_row_per_control_period(arm):
    response = step_response(arm, controller(arm), HOME[arm.name], duration=0.1, rate=RATE)
    assert response.time.shape == (100,)
    assert response.error.shape == (100, 6)
    assert response.torque.shape == (100, arm.nv)
    np.testing.assert_allclose(response.error[0], [0.0, 0.0, 0.02, 0.0, 0.0, 0.0], atol=1e-12)
    assert response.torque_share == np.abs(response.torque / arm.torque_limit).max()


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"displacement": (0.0, 0.0, 0.0)}, ConfigurationError, "not zero"),
        ({"displacement": (0.0, 0.0)}, ConfigurationError, "three numbers"),
        ({"rotation": (0.0, 0.0, np.nan)}, ConfigurationError, "not finite"),
        ({"duration": -1.0}, ConfigurationError, "duration = -1"),
        ({"q": np.zeros(3)}, ModelError, "shape"),
    ],
)
def test_a_step_that_cannot_be_made_is_rejected(arguments, error, message):
    arm = without_friction("panda")
    with pytest.raises(error, match=message):
        step_response(**{"arm": arm, "controller": controller(arm), "q": HOME["panda"], **arguments})
