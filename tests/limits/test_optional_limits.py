"""The optional limits: torque rate and acceleration; and rates and periods that a loop cannot hold."""

import warnings

import numpy as np
import pytest

import pilegrasp_ctrl as pg
from arms import ARMS, HOME, without_friction
from pilegrasp_ctrl.exceptions import BrakingWarning, PeriodWarning

RATE = 1000.0
RATE_LIMIT = 1000.0
"""1 N·m/ms, as a Franka allows [N·m/s]."""


@pytest.fixture(params=ARMS)
def arm(request):
    return without_friction(request.param)


def jump(arm, limits, duration=0.6):
    """Torques of a tool whose reference jumps by 5 cm after 0.1 s, and the names of active limits."""
    q, named = HOME[arm.name], set()
    pose = arm.update(q, 0.0 * q).pose
    controller = pg.OperationalSpaceController(arm, posture=q, limits=limits, rate=RATE)

    def torque(observation):
        target = pose if observation.time < 0.1 else pose.moved([0.0, 0.05, 0.0])
        output = controller.step(observation, target)
        assert output.fallback == ""
        named.update(name.partition("[")[0] for name in output.active_limits)
        return output.command.torque

    samples = list(pg.ArmSimulation(arm).run(torque, q, duration, rate=RATE))
    error = arm.update(samples[-1].q, samples[-1].v).translation - pose.translation
    return np.array([sample.torque for sample in samples]), error, named


def test_a_jump_of_the_reference_changes_torques_no_faster_than_the_limit(arm):
    limits = [*pg.limits_of(arm, RATE), pg.TorqueRateLimit(arm, RATE_LIMIT, RATE)]
    torques, error, named = jump(arm, limits)
    assert np.abs(np.diff(torques, axis=0)).max() <= RATE_LIMIT / RATE * (1.0 + 1e-12)
    assert "torque rate" in named
    np.testing.assert_allclose(error, [0.0, 0.05, 0.0], atol=1e-3)
    free, *_ = jump(arm, pg.limits_of(arm, RATE), 0.2)
    assert np.abs(np.diff(free, axis=0)).max() > 10.0


def test_the_torque_rate_holds_from_the_torque_that_was_commanded_last_and_reset_forgets_it(arm):
    q = HOME[arm.name]
    limit = pg.TorqueRateLimit(arm, RATE_LIMIT, RATE)
    controller = pg.InverseDynamics(
        arm, [pg.PostureTask(arm, q + 0.5, 400.0, weight=1.0)], ["torque", limit], rate=RATE
    )
    controller.remember(0.0, np.zeros(arm.nv))
    torque = controller.step(pg.Observation(0.001, q, 0.0 * q)).command.torque
    assert np.abs(torque).max() <= 1.0 + 1e-9
    controller.reset()
    assert np.abs(controller.step(pg.Observation(0.002, q, 0.0 * q)).command.torque).max() > 10.0


def test_joint_accelerations_stay_within_their_limit(arm):
    q = HOME[arm.name]
    goal = pg.PostureTask(arm, q + 0.3, 400.0, weight=1.0)
    limit = pg.AccelerationLimit(arm, 3.0)
    output = pg.InverseDynamics(arm, [goal], [*pg.limits_of(arm), limit]).step(pg.Observation(0.0, q, 0.0 * q))
    np.testing.assert_allclose(output.acceleration, 3.0, atol=1e-9)
    assert set(output.active_limits) == {f"acceleration[{joint}] upper" for joint in range(arm.nv)}


@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf, "fast", [1.0, 2.0], None])
def test_unusable_optional_limits_are_refused(value):
    arm = without_friction("panda")
    with pytest.raises(pg.ConfigurationError, match="one positive number, or one for each of panda_joint1"):
        pg.TorqueRateLimit(arm, value)
    with pytest.raises(pg.ConfigurationError, match="one positive number, or one for each of panda_joint1"):
        pg.AccelerationLimit(arm, value)
    with pytest.raises(pg.ConfigurationError, match="rate"):
        pg.TorqueRateLimit(arm, 1000.0, rate=0.0)


def test_gains_that_the_sampled_loop_cannot_hold_are_refused_with_the_rate_that_they_need():
    arm = without_friction("panda")
    for stiffness, rate in ((900.0, 25.0), (1e6, 500.0)):
        with pytest.raises(pg.ConfigurationError, match=f"diverges at {rate:g} Hz; take lower gains, or more than"):
            pg.OperationalSpaceController(arm, pg.MotionGains(stiffness), rate=rate)
    with pytest.raises(pg.ConfigurationError, match=r"PostureTask.*diverges"):
        pg.OperationalSpaceController(arm, posture=pg.PostureTask(arm, HOME["panda"], 1e6))
    with pytest.raises(pg.ConfigurationError, match=r"JointTask.*diverges"):
        pg.InverseDynamics(arm, [pg.JointTask(arm, HOME["panda"], pg.JointImpedance(1e5))])
    with pytest.raises(pg.ConfigurationError, match=r"DampingTask.*diverges"):
        pg.InverseDynamics(arm, [pg.DampingTask(arm, 1100.0)])
    controller = pg.OperationalSpaceController(arm)
    controller.tool.gains = pg.MotionGains(1e6)
    with pytest.raises(pg.ConfigurationError, match="diverges at 500 Hz"):
        controller.step(pg.Observation(0.0, HOME["panda"], np.zeros(7)), arm.update(HOME["panda"], np.zeros(7)).pose)


@pytest.mark.parametrize("ratio", [0.1, 0.5, 1.0, 2.0])
@pytest.mark.parametrize("share", [0.9, 1.1])
def test_the_refusal_is_where_a_sampled_spring_begins_to_diverge(share, ratio):
    rate = 100.0
    stiffness = share * (rate * min(1.0 / ratio, 4.0 * ratio)) ** 2
    damping, h, e, v = 2.0 * ratio * np.sqrt(stiffness), 1.0 / rate, 1.0, 0.0
    for _ in range(2000):
        a = -stiffness * e - damping * v
        e, v = e + h * v + 0.5 * h * h * a, v + h * a
    arm = without_friction("panda")
    if share < 1.0:
        assert abs(e) < 1.0
        pg.OperationalSpaceController(arm, pg.MotionGains(stiffness, ratio), rate=rate)
    else:
        assert abs(e) > 1.0 or np.isnan(e)
        with pytest.raises(pg.ConfigurationError, match="diverges"):
            pg.OperationalSpaceController(arm, pg.MotionGains(stiffness, ratio), rate=rate)


@pytest.mark.parametrize("real", [100.0, 200.0, 2000.0])
def test_a_period_that_is_not_the_stated_one_is_noticed(real):
    arm, q = without_friction("panda"), HOME["panda"]
    pose, controller = arm.update(q, 0.0 * q).pose, pg.OperationalSpaceController(arm, posture=q, rate=500.0)
    controller.step(pg.Observation(0.0, q, 0.0 * q), pose)
    with pytest.warns(PeriodWarning, match="made for 500 Hz"):
        controller.step(pg.Observation(1.0 / real, q, 0.0 * q), pose)


def test_the_stated_period_with_some_jitter_and_a_new_motion_after_reset_give_no_warning():
    arm, q = without_friction("panda"), HOME["panda"]
    pose, controller = arm.update(q, 0.0 * q).pose, pg.OperationalSpaceController(arm, posture=q, rate=500.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for time in (0.0, 0.002, 0.0041, 0.0059, 0.0059, 0.0085):
            controller.step(pg.Observation(time, q, 0.0 * q), pose)
        controller.reset()
        controller.step(pg.Observation(7.0, q, 0.0 * q), pose)
        controller.step(pg.Observation(0.0, q, 0.0 * q), pose)


def test_a_payload_that_is_grasped_is_carried_and_one_that_is_put_down_is_forgotten():
    arm, q = without_friction("panda"), HOME["panda"]
    pose = arm.update(q, 0.0 * q).pose
    controller = pg.OperationalSpaceController(arm, posture=q)
    loaded = pg.ArmSimulation(arm, payload=1.5)

    def sag(samples):
        return np.linalg.norm(arm.update(samples[-1].q, samples[-1].v).translation - pose.translation)

    def run(plant):
        controller.reset()
        return list(plant.run(lambda o: controller.step(o, pose).command.torque, q, 1.0))

    assert sag(run(loaded)) > 4e-3
    controller.set_payload(1.5, [0.0, 0.0, 0.0])
    assert sag(run(loaded)) < 1e-4
    controller.set_payload(0.5, [0.0, 0.0, 0.0])
    controller.set_payload(1.5, [0.0, 0.0, 0.0])
    assert sag(run(loaded)) < 1e-4
    controller.set_payload(0.0, [0.0, 0.0, 0.0])
    assert sag(run(pg.ArmSimulation(arm))) < 1e-4
    for mass in (-1.0, np.nan):
        with pytest.raises(pg.PilegraspError, match="mass"):
            controller.set_payload(mass, [0.0, 0.0, 0.0])


def test_a_payload_under_which_a_joint_cannot_brake_is_named_and_one_that_is_too_heavy_is_refused():
    controller = pg.OperationalSpaceController(without_friction("panda"), posture=HOME["panda"])
    with pytest.warns(BrakingWarning, match="panda_joint"):
        controller.set_payload(6.0, [0.0, 0.0, 0.0])
    kept = controller.arm
    with pytest.raises(pg.PilegraspError, match="cannot brake"):
        controller.set_payload(60.0, [0.0, 0.0, 0.0])
    assert controller.arm is kept
