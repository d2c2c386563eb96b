"""Limits bound the accelerations so that speeds, positions and torques stay within the arm's."""

import numpy as np
import pytest

from arms import ARMS, load, random_states, simulate, without_friction
from pilegrasp_ctrl.control.limit_rows import CheckedLimits
from pilegrasp_ctrl.control.operational_space import OperationalSpaceController
from pilegrasp_ctrl.exceptions import ModelError
from pilegrasp_ctrl.limits.motion_limits import PositionLimit, VelocityLimit
from pilegrasp_ctrl.limits.torque_limit import TorqueLimit
from pilegrasp_ctrl.types import Observation, Reference

RATE = 500.0


@pytest.fixture(params=ARMS)
def arm(request):
    return load(request.param)


def test_torque_rows_hold_exactly_the_torques_within_the_limit(arm):
    q, v = next(random_states(arm, 1))
    state = arm.update(q, v)
    limit = TorqueLimit(arm)
    matrix = np.eye(arm.nv) if limit.matrix is None else limit.matrix
    bounds = limit.rows(state)
    a = np.linalg.solve(state.M, np.linalg.solve(matrix, limit.limit) - state.h)
    np.testing.assert_allclose(bounds.G @ a, bounds.upper, atol=1e-9)
    offset = np.linspace(-3.0, 3.0, arm.nv)
    bounds, shared = limit.rows(state._replace(h=offset)), matrix @ offset
    np.testing.assert_allclose((bounds.lower + shared, bounds.upper + shared), (-limit.limit, limit.limit))


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


def rows_of(arm, limits, q, v):
    """Return the bounds of several limits together on the joint accelerations, as a controller has them."""
    return CheckedLimits(limits, arm.nv).rows(arm.update(q, v))


def test_the_tightest_bound_counts_and_is_named(arm):
    none = np.arange(0)
    limits = [VelocityLimit(arm, RATE), PositionLimit(arm, RATE)]
    for q, v in random_states(arm, 20, speed=0.9):
        rows = rows_of(arm, limits, q, v)
        one, other = (limit.rows(arm.update(q, v)) for limit in limits)
        np.testing.assert_allclose(rows.upper, np.minimum(one.upper, other.upper))
        np.testing.assert_allclose(rows.lower, np.maximum(one.lower, other.lower))
        for joint in range(arm.nv):
            nearer = "velocity" if one.upper[joint] < other.upper[joint] else "position"
            assert rows.names(none, np.array([joint])) == (f"{nearer}[{joint}] upper",)


def test_speed_and_position_do_not_contradict_each_other_outside_the_range(arm):
    limits = [VelocityLimit(arm, RATE), PositionLimit(arm, RATE)]
    for excess in (1e-3, 0.1, 2.0):
        for speed in (-1.5, -0.5, 0.0, 0.5, 1.5):
            v = speed * arm.velocity_limit
            for q in (arm.q_upper + excess, arm.q_lower - excess):
                one, other = (limit.rows(arm.update(q, v)) for limit in limits)
                assert (one.lower <= other.upper).all()
                assert (other.lower <= one.upper).all()


def test_joints_without_limits_have_no_bounds():
    free = without_friction(
        "panda", q_lower=np.full(7, -np.inf), q_upper=np.full(7, np.inf), velocity_limit=np.full(7, np.inf)
    )
    for limits in ([VelocityLimit(free, RATE), PositionLimit(free, RATE)], []):
        rows = rows_of(free, limits, np.zeros(7), np.ones(7))
        assert (rows.lower == -np.inf).all()
        assert (rows.upper == np.inf).all()


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
