"""The position limit keeps each joint able to stop before its limit, and costs nothing in mid-range."""

import numpy as np
import pytest

import pilegrasp_ctrl as pg
from arms import ARMS, HOME, load, random_states, without_friction
from pilegrasp_ctrl.exceptions import ArgumentError, ConfigurationError
from pilegrasp_ctrl.kernels.approach import allowed_speed
from pilegrasp_ctrl.limits.braking import braking_acceleration
from pilegrasp_ctrl.limits.motion_limits import DEMAND, GENTLE_DEMAND, RETREAT, PositionLimit
from pilegrasp_ctrl.plant.arm_simulation import ArmSimulation
from pilegrasp_ctrl.plant.tracking import simulate_tracking
from pilegrasp_ctrl.trajectories.straight_line import StraightLine
from pilegrasp_ctrl.types import MassProperties, Observation, Reference

RATE = 500.0

LINES = {
    "0.45 m forward": ([0.0, -1.11, 0.0, -1.44, 0.0, 1.64, 0.78], [0.45, 0.0, 0.0]),
    "0.5 m sideways": ([-0.3, 0.46, 0.0, -1.98, 0.0, 1.04, 0.78], [0.0, 0.5, 0.0]),
}
MID_RANGE = np.array([0.0, -0.72, 0.0, -2.01, 0.0, 1.67, 0.78])
"""Posture from which the Panda moves 0.25 m along x with every joint more than 1 rad from its limits."""


def loaded(mass, **changes):
    """Return the Panda with its own hand and a load beside it, of which its model knows."""
    tool = MassProperties(mass, np.zeros(3), 1e-3 * mass * np.eye(3)) if mass else None
    return load("panda", tool=tool, **changes)


@pytest.fixture(params=ARMS)
def arm(request):
    return load(request.param)


def track(arm, q, displacement):
    """Return the largest error of the position [m] and the limits that were active, on a line at 0.25 m/s."""
    q = np.array(q)
    start = arm.update(q, np.zeros(7)).pose
    line = StraightLine(start=start, displacement=np.array(displacement), speed=0.25)
    controller = pg.OperationalSpaceController(arm, posture=q)
    motion = simulate_tracking(ArmSimulation(arm), controller, line.at, q, line.duration + 0.2)
    return np.linalg.norm(motion.error[:, :3], axis=1).max(), motion.active_limits()


@pytest.mark.parametrize("line", LINES)
@pytest.mark.parametrize("mass", [0.0, 1.0, 2.25])
def test_a_load_within_the_rating_is_carried_along_a_line_as_without_limits(mass, line):
    error, active = track(loaded(mass), *LINES[line])
    assert error < 2e-4
    assert active == ()


@pytest.mark.parametrize("speed", [None, 100.0, 1e4, np.inf])
def test_a_heavy_load_or_a_placeholder_for_the_velocity_limit_starves_no_joint_in_mid_range(speed):
    changes = {} if speed is None else {"velocity_limit": np.full(7, speed)}
    for mass in (0.0, 3.0):
        error, active = track(loaded(mass, **changes), MID_RANGE, [0.25, 0.0, 0.0])
        assert error < 2e-4
        assert active == ()


def test_in_mid_range_the_torques_are_those_without_the_limit(arm):
    rng = np.random.default_rng(4)
    free = pg.OperationalSpaceController(arm, limits=["torque", "velocity"])
    kept = pg.OperationalSpaceController(arm)
    for _ in range(50):
        q = HOME[arm.name] + rng.uniform(-0.1, 0.1, arm.nv)
        v = 0.3 * arm.velocity_limit * rng.uniform(-1.0, 1.0, arm.nv)
        reference = Reference(arm.update(q + 0.02, v).pose)
        torques = [c.step(Observation(0.0, q, v), reference).command.torque for c in (free, kept)]
        np.testing.assert_array_equal(*torques)


def test_at_rest_a_joint_may_start_as_fast_as_it_can_stop_in_any_posture_and_no_faster_than_in_this_one(arm):
    limit, least = PositionLimit(arm, RATE, margin=0.0), braking_acceleration(arm)
    for q, _ in random_states(arm, 50, seed=2):
        state = arm.update(q, np.zeros(arm.nv))
        bounds = limit.rows(state)
        helped = 0.5 * (arm.torque_limit + np.abs(state.h)) / state.M.diagonal()
        for distance, a in ((arm.q_upper - q, bounds.upper), (q - arm.q_lower, -bounds.lower)):
            for joint in range(arm.nv):
                slow, fast = (
                    allowed_speed(distance[joint], b, 20.0, RETREAT)
                    for b in (least[joint], max(helped[joint], least[joint]))
                )
                # Within the horizon the joint comes nearer, and its speed falls.
                assert 0.9 * slow <= limit.horizon * a[joint] <= fast


def test_a_lower_bound_never_exceeds_an_upper_one(arm):
    narrow = arm.replace(q_lower=HOME[arm.name] - 1e-3, q_upper=HOME[arm.name] + 1e-3)
    rng = np.random.default_rng(6)
    for made in (arm, narrow):
        limit = PositionLimit(made, RATE)
        for _ in range(500):
            q = rng.choice([made.q_lower, made.q_upper]) + rng.normal(0.0, 10.0 ** rng.uniform(-4, 1), made.nv)
            v = rng.normal(0.0, 10.0 ** rng.uniform(-3, 1.5), made.nv)
            bounds = limit.rows(made.update(q, v))
            assert (bounds.lower <= bounds.upper).all()
            assert np.isfinite(bounds.lower).all()


def test_a_joint_found_outside_returns_slowly_and_gently(arm):
    limit, braking = PositionLimit(arm, RATE), braking_acceleration(arm)
    zero = np.zeros(arm.nv)
    for q, sign in ((arm.q_upper + 0.2, 1.0), (arm.q_lower - 0.2, -1.0)):
        bounds = limit.rows(arm.update(q, zero))
        demand = bounds.upper if sign > 0.0 else bounds.lower
        np.testing.assert_allclose(demand, -sign * np.minimum(GENTLE_DEMAND * braking, RETREAT / limit.horizon))
        bounds = limit.rows(arm.update(q, np.full(arm.nv, -sign * RETREAT)))
        np.testing.assert_allclose(bounds.upper if sign > 0.0 else bounds.lower, 0.0, atol=1e-9)


def test_a_joint_that_runs_into_its_limit_is_asked_for_no_more_than_the_torque_can_give(arm):
    limit = PositionLimit(arm, RATE)
    for q, v in random_states(arm, 50, seed=8, speed=1.0):
        state = arm.update(q, v)
        bounds = limit.rows(state)
        spare = 0.5 * (arm.torque_limit + np.abs(state.h)) / state.M.diagonal()
        most = DEMAND * np.maximum(spare, braking_acceleration(arm))
        assert (bounds.upper >= -most).all()
        assert (bounds.lower <= most).all()


def test_gravity_that_helps_a_joint_to_brake_lets_it_go_faster():
    """An arm that leans forward is stopped by its weight on the way back up, and not on the way down."""
    arm = loaded(2.25)
    q = np.array([0.0, 0.9, 0.0, -0.6, 0.0, 1.6, 0.0])
    limit = PositionLimit(arm.replace(q_lower=q - 0.3, q_upper=q + 0.3), RATE)
    bounds = limit.rows(arm.update(q, np.zeros(7)))
    assert -bounds.lower[1] > 1.5 * bounds.upper[1]


def test_a_payload_taken_up_in_motion_counts():
    empty = loaded(0.0)
    limit, q = PositionLimit(empty, RATE), np.array([0.0, 1.2, 0.0, -0.6, 0.0, 1.6, 0.0])
    carrying = empty.with_payload(2.25, np.zeros(3))
    light, heavy = (limit.rows(arm.update(q, np.zeros(7))) for arm in (empty, carrying))
    assert heavy.upper[1] < 0.7 * light.upper[1]
    fresh = PositionLimit(carrying, RATE).rows(carrying.update(q, np.zeros(7)))
    np.testing.assert_array_equal(heavy.upper, fresh.upper)
    again = limit.rows(empty.update(q, np.zeros(7)))
    np.testing.assert_array_equal(again.upper, light.upper)


def test_the_torque_of_an_ideal_motor_makes_the_approach_exponential():
    arm = without_friction("panda", torque_limit=np.full(7, 1e12))
    bounds = PositionLimit(arm, RATE, margin=0.0).rows(arm.update(HOME["panda"], np.zeros(7)))
    distance = arm.q_upper - HOME["panda"]
    np.testing.assert_allclose(bounds.upper * 0.004, distance / 0.05 / (1.0 + 0.5 * 0.004 / 0.05))


@pytest.mark.parametrize(
    "arguments",
    [{"rate": -1.0}, {"margin": -0.1}, {"share": 1.5}, {"share": 0.0}, {"stopping_time": 0.0}, {"retreat": "slow"}],
)
def test_a_number_out_of_range_is_refused_by_name(arguments):
    with pytest.raises(ConfigurationError, match=next(iter(arguments))):
        PositionLimit(load("panda"), **arguments)


def test_what_is_no_arm_is_refused():
    with pytest.raises(ArgumentError, match="PositionLimit takes the arm"):
        PositionLimit("panda")
