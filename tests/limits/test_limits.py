"""Limits bound the accelerations so that speeds, positions and torques stay within the arm's."""

import numpy as np
import pytest

from arms import ARMS, load, random_states, simulate, without_friction
from pilegrasp_ctrl.control.operational_space import OperationalSpaceController
from pilegrasp_ctrl.exceptions import ModelError
from pilegrasp_ctrl.limits.acceleration_bounds import AccelerationBounds
from pilegrasp_ctrl.limits.motion_limits import PositionLimit, VelocityLimit, braking_acceleration
from pilegrasp_ctrl.limits.torque_limit import TorqueLimit
from pilegrasp_ctrl.types import Observation, Reference

RATE = 500.0


@pytest.fixture(params=ARMS)
def arm(request):
    return load(request.param)


def bounds_at(limit, q, v):
    """Return the lower and the upper bounds on the accelerations at one state."""
    bounds, x = limit.bounds(), np.concatenate((q, v))
    return bounds.lower_matrix @ x + bounds.lower_offset, bounds.upper_matrix @ x + bounds.upper_offset


def advance(q, v, a, time):
    return q + time * v + 0.5 * time**2 * a, v + time * a


def test_the_velocity_bound_ends_at_the_limit_after_its_horizon(arm):
    limit = VelocityLimit(arm, RATE, margin=0.0)
    q, v = next(random_states(arm, 1))
    lower, upper = bounds_at(limit, q, v)
    assert limit.horizon == pytest.approx(2.0 / RATE)
    np.testing.assert_allclose(advance(q, v, upper, limit.horizon)[1], arm.velocity_limit, atol=1e-12)
    np.testing.assert_allclose(advance(q, v, lower, limit.horizon)[1], -arm.velocity_limit, atol=1e-12)


def test_the_position_bound_ends_where_the_joint_can_still_stop(arm):
    limit = PositionLimit(arm, RATE, margin=0.0)
    for state in random_states(arm, 10, speed=1.0):
        lower, upper = bounds_at(limit, *state)
        q, v = advance(*state, upper, limit.horizon)
        np.testing.assert_allclose(v, limit.gain * (arm.q_upper - q), atol=1e-9)
        q, v = advance(*state, lower, limit.horizon)
        np.testing.assert_allclose(v, limit.gain * (arm.q_lower - q), atol=1e-9)


def test_a_joint_held_at_its_bound_slows_down_within_its_braking_and_stops_inside(arm):
    limit = PositionLimit(arm, RATE, margin=0.0)
    braking = braking_acceleration(arm)
    v = 0.9 * arm.velocity_limit
    q = arm.q_upper - v / limit.gain
    hardest = np.zeros(arm.nv)
    for _ in range(3000):
        a = bounds_at(limit, q, v)[1]
        hardest = np.minimum(hardest, a)
        q, v = advance(q, v, a, 1.0 / RATE)
        assert (q <= arm.q_upper).all()
    assert (hardest >= -1.05 * braking).all()
    np.testing.assert_allclose(q, arm.q_upper, atol=1e-2)


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
        spare = arm.torque_limit - np.abs(state.h) - arm.friction_coulomb
        spare_acceleration = np.minimum(spare_acceleration, spare / state.M.diagonal())
    # These postures differ from the function's, so their worst case is slightly milder.
    np.testing.assert_allclose(braking / spare_acceleration, 0.5, rtol=0.1)


def test_torque_rows_hold_exactly_the_torques_within_the_limit(arm):
    q, v = next(random_states(arm, 1))
    state = arm.update(q, v)
    limit = TorqueLimit(arm)
    matrix = np.eye(arm.nv) if limit.matrix is None else limit.matrix
    lower, upper = np.zeros((2, arm.nv))
    limit.write(lower, upper, state.h)
    a = np.linalg.solve(state.M, np.linalg.solve(matrix, limit.limit) - state.h)
    np.testing.assert_allclose(limit.rows(state.M) @ a, upper, atol=1e-9)
    offset = np.linspace(-3.0, 3.0, arm.nv)
    limit.write(lower, upper, offset)
    shared = offset if limit.matrix is None else limit.matrix @ offset
    np.testing.assert_allclose((lower + shared, upper + shared), (-limit.limit, limit.limit))


def test_two_joints_that_share_motors_cannot_both_have_their_largest_torque():
    arm = load("wam7")
    limit = TorqueLimit(arm)
    tau = np.zeros(7)
    tau[[1, 2]] = 0.9 * arm.torque_limit[[1, 2]]
    motors = np.linalg.solve(arm.joint_to_motor.T, tau)
    assert (np.abs(motors) > arm.motor_torque_limit).any()
    cut = limit.cut(tau)
    assert (np.abs(np.linalg.solve(arm.joint_to_motor.T, cut)) <= arm.motor_torque_limit).all()
    np.testing.assert_array_equal(cut[[0, 3, 4, 5, 6]], 0.0)
    # Power is the same on both sides of the differential.
    v = np.linspace(-1.0, 1.0, 7)
    assert motors @ (arm.joint_to_motor @ v) == pytest.approx(tau @ v)
    # Barrett's joint limits are the motors' torques if only one of the two joints needs torque.
    for joint in (1, 2, 4, 5):
        alone = np.zeros(7)
        alone[joint] = 0.999 * arm.torque_limit[joint]
        np.testing.assert_allclose(limit.cut(alone), alone, atol=1e-9)


def test_an_active_motor_limit_is_named_and_the_torques_stay_within_the_differential():
    arm = load("wam7")
    controller = OperationalSpaceController(arm, friction=False)
    state = arm.update(np.array([0.0, 0.9, 0.0, 1.9, 0.0, -0.5, 0.0]), np.zeros(7))
    named = set()
    for direction in np.vstack((np.eye(3), -np.eye(3))):
        output = controller.step(Observation(0.0, state.q, state.v), Reference(state.pose.moved(0.5 * direction)))
        motors = np.linalg.solve(arm.joint_to_motor.T, output.command.torque)
        shared = [1, 2, 4, 5]
        assert (np.abs(motors[shared]) <= arm.motor_torque_limit[shared]).all()
        named |= {name for name in output.active_limits if name.startswith("motor")}
        for name in output.active_limits:
            if name.startswith("motor"):
                row = int(name[6])
                assert abs(motors[row]) == pytest.approx(arm.motor_torque_limit[row], rel=1e-6)
    assert named


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"joint_to_motor": np.eye(7)}, "go together"),
        ({"joint_to_motor": np.zeros((7, 7)), "motor_torque_limit": np.ones(7)}, "invertible"),
        ({"joint_to_motor": np.eye(7), "motor_torque_limit": np.zeros(7)}, "positive"),
        (
            {"joint_to_motor": np.eye(7) + np.eye(7, k=1), "motor_torque_limit": np.full(7, 1e3)},
            "lower motor_torque_limit",
        ),
    ],
)
def test_an_inconsistent_transmission_is_rejected(arguments, message):
    with pytest.raises(ModelError, match=message):
        without_friction("panda", **arguments)


def test_the_demand_on_a_joint_outside_its_range_is_bounded(arm):
    velocity, position = VelocityLimit(arm, RATE), PositionLimit(arm, RATE)
    demand = np.full(arm.nv, 20.0)
    bounds = AccelerationBounds([velocity, position], arm.nv, demand)
    _, lower, upper = intersect(bounds, arm.q_upper + 0.1, 1.2 * arm.velocity_limit)
    np.testing.assert_array_equal(upper, -20.0)
    assert (lower <= upper).all()


def intersect(bounds, q, v):
    n = len(q)
    values = bounds.split(bounds.matrix @ np.concatenate((q, v, [1.0])))
    lower, upper = np.zeros(n), np.zeros(n)
    bounds.intersect(values, lower, upper)
    return values, lower, upper


def test_the_tightest_bound_counts_and_is_named(arm):
    velocity, position = VelocityLimit(arm, RATE), PositionLimit(arm, RATE)
    both = AccelerationBounds([velocity, position], arm.nv)
    for q, v in random_states(arm, 20, speed=0.9):
        values, lower, upper = intersect(both, q, v)
        one, other = bounds_at(velocity, q, v), bounds_at(position, q, v)
        np.testing.assert_allclose(upper, np.minimum(one[1], other[1]))
        np.testing.assert_allclose(lower, np.maximum(one[0], other[0]))
        for joint in range(arm.nv):
            nearer = "velocity" if one[1][joint] < other[1][joint] else "position"
            assert both.name(values, joint, "upper") == f"{nearer}[{joint}] upper"


def test_a_joint_far_outside_its_range_returns_no_faster_than_its_velocity_limit(arm):
    velocity, position = VelocityLimit(arm, RATE), PositionLimit(arm, RATE)
    q, v = arm.q_upper + 2.0, np.zeros(arm.nv)
    _, lower, upper = intersect(AccelerationBounds([velocity, position], arm.nv), q, v)
    assert (lower <= upper).all()
    np.testing.assert_allclose(upper, bounds_at(velocity, q, v)[0])


def test_bounds_exist_for_one_limit_and_for_none(arm):
    q, v = next(random_states(arm, 1))
    velocity = VelocityLimit(arm, RATE)
    _, lower, upper = intersect(AccelerationBounds([velocity], arm.nv), q, v)
    np.testing.assert_allclose((lower, upper), bounds_at(velocity, q, v))
    _, lower, upper = intersect(AccelerationBounds([], arm.nv), q, v)
    assert (lower == -np.inf).all()
    assert (upper == np.inf).all()


def test_joints_without_limits_have_no_bounds():
    free = without_friction(
        "panda", q_lower=np.full(7, -np.inf), q_upper=np.full(7, np.inf), velocity_limit=np.full(7, np.inf)
    )
    bounds = AccelerationBounds([VelocityLimit(free, RATE), PositionLimit(free, RATE)], 7)
    _, lower, upper = intersect(bounds, np.zeros(7), np.ones(7))
    assert (lower == -np.inf).all()
    assert (upper == np.inf).all()


@pytest.mark.parametrize("limit", ["torque", "velocity", "position"])
def test_a_limit_that_is_left_out_is_exceeded(limit):
    """The stress test can therefore fail: without a limit, the same kind of motion exceeds it."""
    arm = without_friction("wam7", torque_limit=0.5 * load("wam7").torque_limit)
    rng = np.random.default_rng(7)
    span, exceeded = arm.q_upper - arm.q_lower, False
    others = [name for name in ("torque", "velocity", "position") if name != limit]
    for _ in range(10):
        start, goal = (arm.q_lower + span * rng.uniform(0.02, 0.98, arm.nv) for _ in range(2))
        controller = OperationalSpaceController(arm, posture=goal, limits=others)
        reference = Reference(arm.update(goal, np.zeros(arm.nv)).pose)
        for _, q, v, torque in simulate(
            arm, lambda o, c=controller, r=reference: c.step(o, r).command.torque, start, 0.3
        ):
            exceeded |= {
                "torque": bool((np.abs(torque) > arm.torque_limit).any()),
                "velocity": bool((np.abs(v) > arm.velocity_limit).any()),
                "position": bool(((q < arm.q_lower) | (q > arm.q_upper)).any()),
            }[limit]
        if exceeded:
            return
    raise AssertionError(f"{limit} was never exceeded")
