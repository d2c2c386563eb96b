"""The momentum observer's estimate, and how its cancellation affects accuracy, stability and contact."""

import numpy as np
import pytest

from arms import ARMS, HOME, load, random_states, with_friction, without_friction
from pilegrasp_ctrl.control.disturbance_observer import DisturbanceObserver, ObservedController
from pilegrasp_ctrl.control.friction_compensation import FrictionCompensation
from pilegrasp_ctrl.control.operational_space import OperationalSpaceController
from pilegrasp_ctrl.exceptions import ConfigurationError, ModelError
from pilegrasp_ctrl.plant.arm_simulation import ArmSimulation
from pilegrasp_ctrl.plant.tracking import simulate_tracking
from pilegrasp_ctrl.trajectories.straight_line import StraightLine
from pilegrasp_ctrl.tuning.stability_margin import LateController
from pilegrasp_ctrl.types import Observation, Reference
from spring_wall import SpringWall

RATE = 500.0
WRENCH = np.array([6.0, -4.0, 3.0, 0.2, 0.1, -0.1])


class WatchedController:
    """A controller whose disturbance is estimated and recorded, but not cancelled."""

    def __init__(self, controller, observer):
        self.controller, self.observer = controller, observer
        self.torque, self.estimates = np.zeros(observer.arm.nv), []

    def step(self, observation, reference, /):
        self.estimates.append(self.observer.update(observation, self.torque))
        output = self.controller.step(observation, reference)
        self.torque = output.command.torque
        return output


def a_line(arm, speed=0.2):
    return StraightLine(arm.update(HOME[arm.name], np.zeros(7)).pose, [0.0, 0.15, 0.05], speed)


def observed(arm, bandwidth, posture=None, friction=True, **arguments):
    controller = OperationalSpaceController(arm, posture=posture, friction=friction, rate=RATE)
    return ObservedController(controller, DisturbanceObserver(arm, bandwidth, RATE, **arguments))


@pytest.mark.parametrize("bandwidth", [5.0, 20.0])
@pytest.mark.parametrize("name", ARMS)
def test_a_payloads_joint_torque_is_estimated_within_a_hundredth_after_five_time_constants(name, bandwidth):
    arm, home = without_friction(name), HOME[name]
    loaded = ArmSimulation(arm, payload=0.5)
    watched = WatchedController(
        OperationalSpaceController(arm, posture=home), DisturbanceObserver(arm, bandwidth, RATE)
    )
    start = Reference(arm.update(home, np.zeros(7)).pose)
    samples = list(loaded.run(lambda o: watched.step(o, start).command.torque, home, 5.0 / bandwidth + 0.2))
    q = samples[-1].q
    true = arm.update(q, 0.0 * q).h - loaded.plant.update(q, 0.0 * q).h
    assert np.abs(true).max() > 1.0
    assert np.abs(watched.estimates[-1] - true).max() < 0.01 * np.abs(true).max()


@pytest.mark.parametrize("name", ARMS)
def test_a_known_push_is_estimated_during_a_motion(name):
    """The estimate is a first-order low-pass of Jᵀ w, up to the error of the trapezoidal rule at 500 Hz."""
    arm, home, bandwidth = without_friction(name), HOME[name], 20.0
    line = a_line(arm)
    pushed = ArmSimulation(arm, environment=lambda pose, twist: WRENCH)
    watched = WatchedController(
        OperationalSpaceController(arm, posture=home), DisturbanceObserver(arm, bandwidth, RATE, share=1.0)
    )
    samples = list(pushed.run(lambda o: watched.step(o, line.at(o.time)).command.torque, home, 1.6))
    true = np.array([arm.update(sample.q, sample.v).J.T @ WRENCH for sample in samples])
    expected, kept = np.zeros(7), np.exp(-bandwidth / RATE)
    for tick in range(1, len(samples)):
        expected = kept * expected + (1.0 - kept) * 0.5 * (true[tick - 1] + true[tick])
        assert np.abs(watched.estimates[tick] - expected).max() < 2e-3
    assert np.abs(watched.estimates[-1] - true[-1]).max() < 0.01 * np.abs(true[-1]).max()


@pytest.mark.parametrize("name", ARMS)
def test_friction_that_is_fed_forward_does_not_count_as_a_disturbance(name):
    """Otherwise it would be cancelled twice. Without feed-forward, the estimate holds all of it."""
    arm, home = with_friction(name), HOME[name]
    line = a_line(arm)
    rms = {}
    for friction in (True, False):
        controller = OperationalSpaceController(arm, posture=home, friction=friction)
        watched = WatchedController(controller, DisturbanceObserver(arm, 20.0, RATE, share=1.0, friction=friction))
        simulate_tracking(ArmSimulation(arm), watched, line.at, home, line.duration)
        middle = np.array(watched.estimates)[len(watched.estimates) // 3 : len(watched.estimates) // 2]
        rms[friction] = np.sqrt(np.mean((middle / arm.friction_coulomb) ** 2))
    assert rms[True] < 0.3
    assert rms[False] > 0.8


@pytest.mark.parametrize("name", ARMS)
def test_encoder_noise_appears_in_the_estimate_as_bandwidth_times_momentum(name):
    arm, home, bandwidth, deviation = without_friction(name), HOME[name], 20.0, 1e-3
    observer, random = DisturbanceObserver(arm, bandwidth, RATE, share=1.0), np.random.default_rng(0)
    state = arm.update(home, np.zeros(7))
    estimates = [
        observer.update(Observation(tick / RATE, home, deviation * random.standard_normal(7)), state.h)
        for tick in range(6000)
    ]
    share = 1.0 - np.exp(-bandwidth / RATE)
    expected = share * RATE * np.sqrt(2.0 / (2.0 - share)) * deviation * np.linalg.norm(state.M, axis=1)
    np.testing.assert_allclose(np.std(estimates[500:], axis=0), expected, rtol=0.1)
    assert expected == pytest.approx(bandwidth * deviation * np.linalg.norm(state.M, axis=1), rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("factor", [0.7, 1.3])
@pytest.mark.parametrize("name", ARMS)
def test_with_payload_and_wrong_friction_the_error_is_below_0_15_mm(name, factor):
    arm, home = with_friction(name), HOME[name]
    line = a_line(arm, 0.1)
    true = {"friction_coulomb": factor * arm.friction_coulomb, "friction_viscous": factor * arm.friction_viscous}
    left = {}
    for posture in (None, home):
        for controller in (OperationalSpaceController(arm, posture=posture), observed(arm, 10.0, posture)):
            motion = simulate_tracking(
                ArmSimulation(arm, payload=0.5, **true), controller, line.at, home, line.duration + 1.5
            )
            left[posture is None, type(controller).__name__] = np.linalg.norm(motion.error[-1, :3])
    assert left[True, "OperationalSpaceController"] > 1e-3
    assert left[True, "ObservedController"] < 2e-5
    # A posture that the tool does not allow pulls on it at the rate at which friction lets the arm creep.
    assert left[False, "OperationalSpaceController"] > 1e-3
    assert left[False, "ObservedController"] < 1.5e-4


@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_a_faster_approach_of_the_friction_feed_forward_reduces_the_pull_of_the_posture(name):
    arm, home = with_friction(name), HOME[name]
    line = a_line(arm, 0.1)
    controller = observed(arm, 10.0, home, friction=FrictionCompensation(arm, error_rate=15.0))
    motion = simulate_tracking(ArmSimulation(arm, payload=0.5), controller, line.at, home, line.duration + 1.5)
    assert np.linalg.norm(motion.error[-1, :3]) < 1e-4


@pytest.mark.slow
@pytest.mark.parametrize(
    ("periods", "bandwidth", "quiet"),
    [(0, 250.0, True), (1, 250.0, True), (2, 200.0, True), (4, 50.0, True), (4, 100.0, False), (6, 20.0, False)],
)
@pytest.mark.parametrize("name", ARMS)
def test_late_torques_limit_the_bandwidth(name, periods, bandwidth, quiet):
    arm, home = without_friction(name), HOME[name]
    start = Reference(arm.update(home, np.zeros(7)).pose)
    late = LateController(observed(arm, bandwidth, home), periods)
    motion = simulate_tracking(ArmSimulation(arm, payload=0.5), late, lambda time: start, home, 1.2 if quiet else 2.0)
    swing = np.ptp(motion.error[-100:, :3], axis=0).max()
    assert swing < 1e-6 if quiet else swing > 1e-3


@pytest.mark.parametrize("factor", [0.5, 1.0, 2.0])
def test_the_observer_is_stable_with_half_and_with_twice_the_modelled_masses(factor):
    arm, home = without_friction("wam7"), HOME["wam7"]
    line = a_line(arm)
    plant = ArmSimulation(arm, mass_factor=factor)
    motion = simulate_tracking(plant, observed(arm, 50.0, home, share=1.0), line.at, home, line.duration + 1.0)
    assert motion.fallbacks == 0
    assert np.linalg.norm(motion.error[-1, :3]) < 1e-4
    assert np.ptp(motion.error[-100:], axis=0).max() < 1e-5


class HoldingController:
    """An observed controller that may hold its estimate once the contact force exceeds 1 N."""

    def __init__(self, arm, bandwidth, holds):
        self.controller = OperationalSpaceController(arm, posture=HOME[arm.name])
        self.observer = DisturbanceObserver(arm, bandwidth, RATE) if bandwidth else None
        self.holds, self.torque = holds, np.zeros(arm.nv)

    def step(self, observation, reference, /):
        estimate = None
        if self.observer is not None:
            contact = self.holds and np.linalg.norm(observation.wrench[:3]) > 1.0
            estimate = self.observer.update(observation, self.torque, hold=contact)
        output = self.controller.step(observation, reference, disturbance=estimate)
        self.torque = output.command.torque
        return output


@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_without_hold_the_estimate_increases_the_contact_force(name):
    """Cancelling the contact force presses ever harder, up to the bound. A held estimate still carries the payload."""
    arm, home = without_friction(name), HOME[name]
    start = arm.update(home, np.zeros(7)).pose
    table = SpringWall(start.translation - np.array([0.0, 0.0, 0.02]), [0.0, 0.0, 1.0], 2e4, 50.0)
    down = StraightLine(start, [0.0, 0.0, -0.025], 0.02)

    def at(time):
        return down.at(max(0.0, time - 1.0))

    force = {}
    for bandwidth, holds in ((0.0, False), (10.0, False), (10.0, True)):
        plant = ArmSimulation(arm, payload=0.5, environment=table, substeps=4)
        controller = HoldingController(arm, bandwidth, holds)
        *_, last = plant.run(lambda o, c=controller: c.step(o, at(o.time)).command.torque, home, 3.6)
        force[bandwidth, holds] = last.wrench[2]
    expected = {"wam7": (11.6, 56.2, 7.2), "panda": (19.5, 61.8, 15.4)}[name]
    assert tuple(force.values()) == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize("name", ARMS)
def test_the_disturbance_is_subtracted_from_the_torque(name):
    arm = load(name)
    controller = OperationalSpaceController(arm, limits=(), posture=HOME[name])
    disturbance = np.linspace(2.0, -1.0, 7)
    for q, v in random_states(arm, 5):
        observation, reference = Observation(0.0, q, v), Reference(arm.update(HOME[name], v).pose)
        plain, cancelled = (controller.step(observation, reference, disturbance=d) for d in (None, disturbance))
        np.testing.assert_allclose(plain.command.torque - cancelled.command.torque, disturbance, atol=1e-9)
        np.testing.assert_allclose(plain.acceleration, cancelled.acceleration, atol=1e-9)


@pytest.mark.parametrize("name", ARMS)
def test_a_cancelled_disturbance_counts_in_the_torque_limits(name):
    arm = without_friction(name)
    q = HOME[name]
    state = arm.update(q, 0.0 * q)
    disturbance = -0.9 * arm.torque_limit * np.sign(state.h)
    output = OperationalSpaceController(arm).step(
        Observation(0.0, q, 0.0 * q), Reference(state.pose), disturbance=2.0 * disturbance
    )
    assert output.fallback == ""
    assert output.active_limits
    assert (np.abs(output.command.torque) <= arm.torque_limit + 1e-9).all()


@pytest.mark.parametrize("disturbance", [np.zeros(6), np.full(7, np.nan), 1.0])
def test_a_disturbance_that_cannot_be_used_is_rejected(disturbance):
    arm, q = load("panda"), HOME["panda"]
    with pytest.raises(ConfigurationError, match="disturbance must be 7 finite numbers"):
        OperationalSpaceController(arm).step(
            Observation(0.0, q, 0.0 * q), Reference(arm.update(q, 0.0 * q).pose), disturbance=disturbance
        )


def at_rest(arm, time=0.0):
    return Observation(time, HOME[arm.name], np.zeros(7))


def missing(arm, torque):
    """Return the torque that would be commanded if the environment carried `torque`."""
    return arm.update(HOME[arm.name], np.zeros(7)).h - torque


def test_the_estimate_is_bounded_and_leaves_its_bound_at_once():
    arm = without_friction("panda")
    observer = DisturbanceObserver(arm, 50.0, RATE, share=0.2)
    np.testing.assert_allclose(observer.bound, 0.2 * arm.torque_limit)
    load_torque = 0.5 * arm.torque_limit
    for tick in range(200):
        estimate = observer.update(at_rest(arm, tick / RATE), missing(arm, load_torque))
    np.testing.assert_allclose(estimate, observer.bound)
    back = observer.update(at_rest(arm, 200 / RATE), missing(arm, 0.0 * load_torque))
    np.testing.assert_allclose(back, np.exp(-50.0 / RATE) * observer.bound)


def test_reset_clears_the_estimate_and_hold_keeps_it():
    arm, torque = without_friction("panda"), np.linspace(1.0, -1.0, 7)
    observer = DisturbanceObserver(arm, 50.0, RATE)
    for tick in range(300):
        estimate = observer.update(at_rest(arm, tick / RATE), missing(arm, torque))
    np.testing.assert_allclose(estimate, torque, atol=1e-9)
    for tick in range(300, 400):
        held = observer.update(at_rest(arm, tick / RATE), missing(arm, -3.0 * torque), hold=True)
    np.testing.assert_array_equal(held, estimate)
    np.testing.assert_array_equal(observer.estimate, estimate)
    observer.reset()
    np.testing.assert_array_equal(observer.estimate, 0.0)
    np.testing.assert_array_equal(observer.update(at_rest(arm, 1.0), missing(arm, torque)), 0.0)


def test_the_returned_estimate_is_a_copy():
    arm = without_friction("panda")
    observer = DisturbanceObserver(arm)
    observer.update(at_rest(arm), missing(arm, np.ones(7)))
    estimate = observer.update(at_rest(arm, 1.0 / RATE), missing(arm, np.ones(7)))
    kept = estimate.copy()
    estimate += 1.0
    np.testing.assert_array_equal(observer.estimate, kept)


def test_the_estimate_ignores_time_that_repeats_jumps_or_goes_backwards():
    arm, torque = without_friction("panda"), np.ones(7)
    observer = DisturbanceObserver(arm, 20.0, RATE)
    for tick in range(50):
        estimate = observer.update(at_rest(arm, tick / RATE), missing(arm, torque))
    last = 49 / RATE
    for time in (last, last + 5.0, 0.0, np.nan, 1.0):
        np.testing.assert_array_equal(observer.update(at_rest(arm, time), missing(arm, 9.0 * torque)), estimate)
    late = observer.update(at_rest(arm, 1.0 + 3.0 / RATE), missing(arm, torque))
    np.testing.assert_allclose(late, 1.0 - np.exp(-20.0 * 3.0 / RATE) * (1.0 - estimate), atol=1e-9)


def test_values_that_are_not_finite_are_rejected_and_keep_the_estimate():
    arm = without_friction("panda")
    observer = DisturbanceObserver(arm)
    for tick in range(20):
        estimate = observer.update(at_rest(arm, tick / RATE), missing(arm, np.ones(7)))
    bad = np.full(7, np.nan)
    with pytest.raises(ModelError, match="not finite"):
        observer.update(Observation(0.1, bad, np.zeros(7)), np.zeros(7))
    for torque in (bad, np.zeros(6)):
        with pytest.raises(ModelError, match="commanded torque must be 7 finite numbers"):
            observer.update(at_rest(arm, 0.1), torque)
    wild = observer.update(Observation(20 / RATE, HOME["panda"], np.full(7, 1e100)), np.zeros(7))
    assert np.isfinite(wild).all()
    assert (np.abs(wild) <= observer.bound).all()
    assert np.isfinite(estimate).all()


@pytest.mark.parametrize(
    "argument",
    [{"bandwidth": 0.0}, {"bandwidth": np.nan}, {"rate": -1.0}, {"share": 0.0}, {"friction_scale": np.inf}],
)
def test_unusable_numbers_are_rejected(argument):
    with pytest.raises(ConfigurationError, match=next(iter(argument))):
        DisturbanceObserver(load("wam7"), **argument)


def test_a_bandwidth_beyond_the_rate_is_rejected():
    with pytest.raises(ConfigurationError, match=r"too fast for 100\.0 Hz; take at most 50\.0"):
        DisturbanceObserver(load("wam7"), 80.0, 100.0)
