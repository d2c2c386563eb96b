"""The measures of a search over gains, its choice, and the stability margin."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import arms
from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.control.sampled_data import stiffness_margin
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.tasks.gains import Impedance, MotionGains, load_gains
from pilegrasp_ctrl.tuning.choice import choose, pareto_front
from pilegrasp_ctrl.tuning.gain_space import GainSpace, gains_table, gains_text
from pilegrasp_ctrl.tuning.objectives import LEVER, Measured, UnfinishedError, combined, measure
from pilegrasp_ctrl.tuning.stability_margin import find_margin, stiffness_probe
from pilegrasp_ctrl.tuning.store import TrialRecord
from pilegrasp_ctrl.tuning.trial import TrialReport
from pilegrasp_ctrl.types import Outcome

# Gains


@pytest.mark.parametrize(
    "gains",
    [
        MotionGains([900.0, 900.0, 450.0, 1600.1, 1600.1, 1600.1], 0.7),
        Impedance(1000.0, 0.7),
        Impedance([1000.0, 2000.0, 0.0, 50.0, 50.0, 70.0], damping=[0, 0, 30.0, 0, 0, 0], frame="tool"),
        Impedance([1000.0] * 3 + [50.0] * 3, inertia=[5.0] * 3 + [0.1] * 3, dead_band=(1.0, 0.1)),
    ],
)
def test_gains_survive_the_file_and_the_space(tmp_path, gains):
    file = tmp_path / "gains.toml"
    file.write_text(gains_text(gains, "two\nlines"))
    assert gains_table(load_gains(file)) == gains_table(gains)
    space = GainSpace.around(gains, 500.0)
    assert gains_table(space.gains(space.rounded(space.start_values))) == gains_table(gains)
    stiffer = space.gains({**space.start_values, "translation": 2.0 * space.start_values["translation"]})
    np.testing.assert_allclose(stiffer.stiffness[:3], 2.0 * gains.stiffness[:3])
    np.testing.assert_array_equal(stiffer.stiffness[3:], gains.stiffness[3:])


def test_bounds_follow_the_rate_and_hold_the_start():
    assert GainSpace.around(MotionGains(400.0), 1000.0).bounds["translation"] == (25.0, 40000.0)
    assert GainSpace.around(MotionGains(9.0, 3.0), 500.0).bounds["translation"] == (9.0, 10000.0)
    assert GainSpace.around(MotionGains(9.0, 3.0), 500.0).bounds["damping_ratio"] == (0.3, 3.0)


# Objectives


def attempt(time, force, push, **signals):
    zeros = np.zeros(len(time))
    given = {"push_force": force, "tracking_error": zeros, "orientation_error": zeros, "torque_ratio": zeros[:, None]}
    recording = SimpleNamespace(signal_time=time, signals={**given, **signals})
    line = Outcome("approach", "ended", "surface contact", 0.0, 1.0, 0.1, 0.0)
    return SimpleNamespace(seed=0, outcomes=(line, push), recording=recording)


@pytest.mark.parametrize("end", [1.15, 1.148])
def test_the_overshoot_is_the_force_before_the_sensor_smoothed_it(end):
    """A force that rises by 200 N/s passes F_grasp = 17 N on the sensor when the hand already feels more."""
    scenario = load_scenario("push_wall")
    tick = np.arange(0, round(1000 * end) + 1, 2) / 1000.0
    raw = 200.0 * np.clip(tick - 1.05, 0.0, None)
    smooth, level = [], 0.0
    for value in raw:
        level += (1.0 - np.exp(-2.0 * np.pi * scenario.sensor.cutoff * 0.002)) * (value - level)
        smooth.append(level)
    smooth = np.array(smooth)
    rows = np.flatnonzero(np.round(1000 * tick).astype(int) % 10 == 0)
    push = Outcome("push", "ended", "grasp force", 1.0, tick[-1], 0.1, smooth[-1])
    result = measure(attempt(tick[rows], smooth[rows], push), scenario)
    # The mean of the raw force over the last interval lies half an interval's rise, at most 1 N, below its end.
    assert raw[-1] - 17.0 - 1.01 < result.overshoot < raw[-1] - 17.0
    assert result.overshoot > smooth[-1] - 17.0 + 2.0


def test_tracking_weighs_rotation_and_leaves_contact_out():
    time = np.arange(0.0, 2.0, 0.01)
    free = time <= 1.0
    push = Outcome("push", "ended", "grasp force", 1.0, 2.0, 0.1, 18.0)
    result = measure(
        attempt(
            time,
            np.zeros(200),
            push,
            tracking_error=np.where(free, 0.003, 0.05),
            orientation_error=np.where(free, 0.004 / LEVER, 0.5),
            torque_ratio=np.tile([0.5, 0.52], 100)[:, None],
        ),
        load_scenario("push_wall"),
    )
    assert result.tracking == pytest.approx(5.0)
    assert result.activity == pytest.approx(2.0)
    assert combined([result, replace(result, tracking=0.0, overshoot=9.0)]).tracking == pytest.approx(5.0 / 2**0.5)
    assert combined([replace(result, overshoot=3.0), replace(result, overshoot=9.0)]).overshoot == 9.0


def test_an_attempt_that_was_not_completed_is_not_measured():
    push = Outcome("push", "failed", "travel limit", 1.0, 2.0, 0.1, 3.0)
    with pytest.raises(UnfinishedError, match="seed 0: push: travel limit"):
        measure(attempt(np.arange(3.0), np.zeros(3), push), load_scenario("push_wall"))


def record(number, tracking, activity, ringing=0.0, overshoot=None):
    report = TrialReport(
        number, Measured(tracking, activity, overshoot, 0.0, 0.0, 0.0), (ringing, ringing), 1.0, "", 0.0
    )
    return TrialRecord(number, {}, report)


def test_the_front_and_the_choice():
    records = [record(0, 1.0, 1.0), record(1, 0.5, 1.2), record(2, 0.6, 1.3), record(3, 0.1, 0.9, ringing=2.0)]
    assert [found.number for found in pareto_front(records)] == [1, 0]
    best, rule = choose(records, 17.0)
    assert best.number == 1
    assert "do not ring" in rule
    best, rule = choose([record(0, 1.0, 1.0, ringing=3.0), record(1, 2.0, 1.0, ringing=2.0)], 17.0)
    assert best.number == 1
    assert "do not use it" in rule
    gentle = [record(0, 1.0, 1.0, overshoot=20.0), record(1, 1.0, 1.0, overshoot=3.0)]
    assert choose(gentle, 17.0)[0].number == 1


# Margins


@pytest.mark.parametrize("known", [1.3, 3.7, 15.0, 0.8, 0.1])
def test_the_margin_is_found(known):
    margin = find_margin(lambda factor: factor / known)
    assert margin.limited
    assert known / 1.05 <= margin.factor < known
    assert [factor for factor, _ in margin.probes] == sorted(factor for factor, _ in margin.probes)


def test_a_loop_that_never_or_always_rings():
    assert str(find_margin(lambda factor: 0.0)) == "at least 16"
    assert find_margin(lambda factor: 2.0).factor == 0.0
    with pytest.raises(ConfigurationError, match="above 1"):
        find_margin(lambda factor: 0.0, highest=1.0)


def test_the_margin_of_a_sampled_mass_is_the_one_that_jury_gives():
    """A critically damped unit mass under a held force is stable for omega h < 1: (1 / (20 · 0.002))² = 625."""

    def ringing(factor):
        stiffness, h = factor * 20.0**2, 0.002
        x, v, forces = 0.005, 0.0, []
        for _ in range(500):
            force = -stiffness * x - 2.0 * np.sqrt(stiffness) * v
            x, v = x + h * v + 0.5 * h * h * force, v + h * force
            forces.append(force)
            if abs(force) > 1e6:
                return 1e6
        return np.ptp(forces[-125:])

    assert find_margin(ringing, highest=1024.0).factor == pytest.approx(625.0, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("name", arms.ARMS)
@pytest.mark.parametrize(
    "gains", [MotionGains(1600.0), Impedance([400.0] * 3 + [20.0] * 3)], ids=lambda g: type(g).__name__
)
def test_too_stiff_too_late_and_too_little_damping_ring_on_both_arms(name, gains):
    arm, q = arms.load(name), arms.HOME[name]
    probe = stiffness_probe(arm, gains, q, rate=500.0)
    assert probe(1.0) < 1.0 < probe(1000.0)
    assert stiffness_probe(arm, replace(gains, damping_ratio=0.1), q, rate=500.0)(1.0) > 1.0
    assert stiffness_probe(arm, gains, q, rate=500.0, late=20)(1.0) > 1.0


@pytest.mark.parametrize("name", arms.ARMS)
def test_the_margin_of_an_impedance_is_that_of_its_sampled_loop(name):
    arm, q = arms.load(name), arms.HOME[name]
    gains = Impedance([1000.0] * 3 + [50.0] * 3, damping_ratio=0.7)
    margin = find_margin(stiffness_probe(arm, gains, q, rate=500.0), highest=64.0)
    assert margin.factor == pytest.approx(stiffness_margin(arm, gains, q, 500.0), rel=0.1)
