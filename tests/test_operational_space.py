import numpy as np
import pinocchio as pin
import pytest
from arms import ARMS, HOME, load, panda_urdf, random_states, simulate, without_friction

from pilegrasp_ctrl.arm_model import ArmModel
from pilegrasp_ctrl.control import inverse_dynamics
from pilegrasp_ctrl.control.friction import FrictionCompensation
from pilegrasp_ctrl.control.gains import Impedance, MotionGains
from pilegrasp_ctrl.control.khatib import least_squares_torque, operational_space_torque
from pilegrasp_ctrl.control.operational_space import OperationalSpaceController
from pilegrasp_ctrl.exceptions import ConfigurationError, ModelError
from pilegrasp_ctrl.tasks.frame_motion_task import FrameMotionTask
from pilegrasp_ctrl.tasks.frame_task import pose_error
from pilegrasp_ctrl.tasks.posture_task import PostureTask
from pilegrasp_ctrl.trajectories.straight_line import StraightLine
from pilegrasp_ctrl.types import MassProperties, Observation, Pose, Reference

GAINS = MotionGains([400.0] * 3 + [900.0] * 3)
HAND = MassProperties(0.6, [0.03, 0.0, 0.08], np.diag([1.5e-3, 1.5e-3, 6e-4]))


@pytest.fixture(params=ARMS)
def arm(request):
    return load(request.param)


def nearby(state, turn=0.05):
    shift, rotation = np.array([0.01, -0.02, 0.015]), pin.exp3(np.array([turn, 0.0, -turn]))
    pose = Pose(state.translation + shift, rotation @ state.rotation)
    return Reference(pose, np.linspace(-0.1, 0.1, 6), np.linspace(0.5, -0.5, 6))


def quiet_states(arm, count):
    """States around the home posture at which no limit is near."""
    rng = np.random.default_rng(1)
    for _ in range(count):
        yield HOME[arm.name] + rng.uniform(-0.1, 0.1, arm.nv), rng.uniform(-0.1, 0.1, arm.nv)


def wanted_by(gains, state, reference):
    return FrameMotionTask(gains).acceleration(state, reference, pose_error(state, reference))


def test_the_torque_is_the_closed_form_where_no_limit_is_active(arm):
    home, weight, mask = HOME[arm.name], np.array([1, 2, 3, 1, 1, 0.5]), [1, 1, 1, 1, 0, 1]
    posture = PostureTask(home, stiffness=50.0, weight=1e-3)
    controller = OperationalSpaceController(arm, GAINS, posture, weight=weight, mask=mask, friction=False)
    for q, v in quiet_states(arm, 10):
        state = arm.update(q, v)
        reference = nearby(state)
        output = controller.step(Observation(0.0, q, v), reference)
        assert output.active_limits == ()
        expected = least_squares_torque(
            state,
            wanted_by(GAINS, state, reference),
            50.0 * (home - q) - 2.0 * np.sqrt(50.0) * v,
            weight * mask,
            1e-3,
        )
        np.testing.assert_allclose(output.command.torque, expected, atol=1e-9)
        np.testing.assert_allclose(state.M @ output.acceleration + state.h, output.command.torque, atol=1e-9)


def test_the_tool_accelerates_as_under_khatibs_formula_as_the_posture_loses_weight(arm):
    q, v = next(quiet_states(arm, 1))
    state = arm.update(q, v)
    reference = nearby(state)
    closed = operational_space_torque(state, wanted_by(GAINS, state, reference), np.linspace(-1.0, 1.0, arm.nv))
    gaps = []
    for weight in (1e-2, 1e-4, 1e-6):
        controller = OperationalSpaceController(arm, GAINS, PostureTask(HOME[arm.name], weight=weight), friction=False)
        torque = controller.step(Observation(0.0, q, v), reference).command.torque
        gaps.append(np.abs(state.J @ np.linalg.solve(state.M, torque - closed)).max())
    assert gaps[0] < 1.0
    np.testing.assert_allclose(np.array(gaps[1:]) / gaps[:-1], 0.01, rtol=0.5)


def test_without_redundancy_the_torque_itself_is_khatibs():
    names = ["panda_finger_joint1", "panda_finger_joint2", "panda_joint3"]
    arm = ArmModel.from_urdf(panda_urdf(), "panda_hand_tcp", locked_joints=names)
    q, v = np.delete(HOME["panda"], 2), np.linspace(-0.1, 0.1, 6)
    state = arm.update(q, v)
    reference = nearby(state)
    controller = OperationalSpaceController(arm, GAINS, PostureTask(q, weight=1e-12), friction=False)
    closed = operational_space_torque(state, wanted_by(GAINS, state, reference), np.zeros(6))
    np.testing.assert_allclose(controller.step(Observation(0.0, q, v), reference).command.torque, closed, atol=1e-6)


def test_khatibs_torque_gives_the_tool_its_acceleration_whatever_the_posture_torque(arm):
    for q, v in quiet_states(arm, 3):
        state, wanted = arm.update(q, v), np.linspace(-1.0, 1.0, 6)
        for posture_torque in (np.zeros(arm.nv), np.linspace(-5.0, 5.0, arm.nv)):
            torque = operational_space_torque(state, wanted, posture_torque)
            a = np.linalg.solve(state.M, torque - state.h)
            np.testing.assert_allclose(state.J @ a + state.Jdot_v, wanted, atol=1e-9)


def track(arm, controller, line, q, coulomb=None):
    """Largest and root-mean-square position error [m] and largest orientation error [rad]."""
    positions, turns = [], []

    def step(observation):
        state = arm.update(observation.q, observation.v)
        reference = line.at(observation.time)
        error = pose_error(state, reference)
        positions.append(np.linalg.norm(error[:3]))
        turns.append(np.linalg.norm(error[3:]))
        return controller.step(observation, reference, state=state).command.torque

    for _ in simulate(arm, step, q, line.duration + 0.1, coulomb=coulomb):
        pass
    return max(positions), np.sqrt(np.mean(np.square(positions))), max(turns)


@pytest.mark.parametrize("name", ARMS)
def test_a_line_in_free_space_is_tracked(name):
    arm, q = without_friction(name), HOME[name]
    line = StraightLine(arm.update(q, np.zeros(7)).pose, [0.0, 0.2, 0.05], 0.25)
    peak, _, turn = track(arm, OperationalSpaceController(arm, posture=q), line, q)
    assert peak < 1e-4
    assert turn < 1e-4


def test_friction_is_compensated_within_a_millimetre_and_not_without_the_feed_forward():
    coulomb, q = load("wam7").friction_coulomb, HOME["wam7"]
    arm = without_friction("wam7", tool=HAND, friction_coulomb=coulomb)
    line = StraightLine(arm.update(q, np.zeros(7)).pose, [0.0, 0.1, 0.0], 0.1)
    on = track(arm, OperationalSpaceController(arm, posture=q), line, q, coulomb)
    off = track(arm, OperationalSpaceController(arm, posture=q, friction=False), line, q, coulomb)
    assert on[0] < 2e-3
    assert on[1] < 1e-3
    assert on[2] < np.radians(0.5)
    assert off[1] > 3.0 * on[1]
    assert off[2] > 3.0 * on[2]


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


def test_friction_is_fed_forward_by_the_reference_not_by_the_measured_velocity():
    arm, q = load("wam7"), HOME["wam7"]
    state = arm.update(q, np.zeros(7))
    plain = OperationalSpaceController(arm, friction=False)
    compensated = OperationalSpaceController(arm, friction=FrictionCompensation(arm, scale=1e-3))

    def extra(v, twist):
        observation, reference = Observation(0.0, q, v), Reference(state.pose, twist)
        return (
            compensated.step(observation, reference).command.torque - plain.step(observation, reference).command.torque
        )

    np.testing.assert_allclose(extra(0.1 * np.ones(7), np.zeros(6)), 0.0, atol=1e-9)
    wanted = np.linalg.pinv(state.J) @ np.array([0.0, 0.1, 0.0, 0.0, 0.0, 0.0])
    expected = arm.friction_coulomb * np.sign(wanted) + arm.friction_viscous * wanted
    np.testing.assert_allclose(extra(np.zeros(7), np.array([0.0, 0.1, 0, 0, 0, 0])), expected, atol=0.02)


def test_the_posture_is_taken_without_moving_the_tool():
    arm, q = without_friction("wam7"), HOME["wam7"]
    state = arm.update(q, np.zeros(7))
    null = np.linalg.svd(state.J)[2][-1]
    target = q + 0.3 * null
    controller = OperationalSpaceController(arm, posture=target)
    reference = Reference(state.pose)
    *_, last = simulate(arm, lambda o: controller.step(o, reference).command.torque, q, 1.0)
    end = arm.update(last[1], last[2])
    assert np.linalg.norm(pose_error(end, reference)) < 2e-4
    assert (last[1] - q) @ null > 0.25


def test_a_posture_given_for_one_period_replaces_the_preferred_one(arm):
    q, v = next(quiet_states(arm, 1))
    reference, other = nearby(arm.update(q, v)), HOME[arm.name] + 0.05
    observation = Observation(0.0, q, v)
    expected = OperationalSpaceController(arm, posture=other, friction=False).step(observation, reference)
    for default in (None, HOME[arm.name]):
        controller = OperationalSpaceController(arm, posture=default, friction=False)
        given = controller.step(observation, reference, posture=other)
        np.testing.assert_allclose(given.command.torque, expected.command.torque, atol=1e-9)
        assert np.abs(controller.step(observation, reference).command.torque - given.command.torque).max() > 1e-6


def test_a_step_remembers_nothing(arm):
    controller = OperationalSpaceController(arm, posture=HOME[arm.name])
    (q, v), (other, w) = quiet_states(arm, 2)
    reference = nearby(arm.update(q, v))
    first = controller.step(Observation(0.0, q, v), reference)
    torque = first.command.torque.copy()
    controller.step(Observation(0.1, other, w), nearby(arm.update(other, w)))
    np.testing.assert_array_equal(first.command.torque, torque)
    again = controller.step(Observation(0.2, q, v), reference, state=arm.update(q, v))
    np.testing.assert_array_equal(again.command.torque, torque)


def limited(arm, **changes):
    return without_friction(arm.name, **changes)


def test_active_limits_are_named_by_joint_and_side(arm):
    q, v = HOME[arm.name], np.zeros(7)
    state = arm.update(q, v)
    up = Reference(state.pose, acceleration=np.array([0.0, 0.0, 30.0, 0.0, 0.0, 0.0]))
    free = OperationalSpaceController(limited(arm), friction=False).step(Observation(0.0, q, v), up)
    assert free.active_limits == ()
    joint = int(np.argmax(np.abs(free.command.torque - state.h)))
    push = free.command.torque[joint] - state.h[joint]
    limit = arm.torque_limit.copy()
    limit[joint] = np.abs(state.h[joint] + 0.5 * push)
    bound = OperationalSpaceController(limited(arm, torque_limit=limit), friction=False).step(
        Observation(0.0, q, v), up
    )
    side = "upper" if state.h[joint] + 0.5 * push > 0.0 else "lower"
    assert f"torque[{joint}] {side}" in bound.active_limits
    assert abs(bound.command.torque[joint]) == pytest.approx(limit[joint], abs=1e-9)

    speed = arm.velocity_limit.copy()
    fast = v.copy()
    fast[joint] = 0.99 * speed[joint] * np.sign(free.acceleration[joint])
    running = Reference(state.pose, state.J @ fast, up.acceleration)
    output = OperationalSpaceController(limited(arm), friction=False).step(Observation(0.0, q, fast), running)
    side = "upper" if fast[joint] > 0.0 else "lower"
    assert f"velocity[{joint}] {side}" in output.active_limits

    near = arm.q_upper.copy() if free.acceleration[joint] > 0.0 else arm.q_lower.copy()
    near[joint] = q[joint] + 0.002 * np.sign(free.acceleration[joint])
    key, side = ("q_upper", "upper") if free.acceleration[joint] > 0.0 else ("q_lower", "lower")
    output = OperationalSpaceController(limited(arm, **{key: near}), friction=False).step(Observation(0.0, q, v), up)
    assert f"position[{joint}] {side}" in output.active_limits


@pytest.mark.parametrize("solver", ["daqp", "osqp"])
@pytest.mark.parametrize("name", ARMS)
def test_there_is_always_a_torque_within_the_limits(name, solver):
    """Weak drives, far outside the ranges, fast: the bounds contradict each other in most of these states."""
    strong = load(name)
    arm = without_friction(name, torque_limit=0.3 * strong.torque_limit, velocity_limit=0.4 * strong.velocity_limit)
    controller = OperationalSpaceController(arm, solver=solver)
    rng = np.random.default_rng(0)
    fallbacks = 0
    for _ in range(30):
        q = arm.q_lower + (arm.q_upper - arm.q_lower) * rng.uniform(-0.1, 1.1, 7)
        v = rng.normal(scale=2.0, size=7)
        pose = arm.update(q + rng.normal(scale=0.3, size=7), v).pose
        output = controller.step(Observation(0.0, q, v), Reference(pose))
        assert np.isfinite(output.command.torque).all()
        assert np.isfinite(output.acceleration).all()
        assert (np.abs(output.command.torque) <= arm.torque_limit).all()
        fallbacks += output.fallback != ""
    assert fallbacks <= (0 if solver == "daqp" else 3)


@pytest.mark.parametrize("speed", [1e3, 1e50, 1e100])
def test_an_absurd_speed_gives_a_finite_torque(arm, speed):
    controller = OperationalSpaceController(arm)
    q = HOME[arm.name]
    output = controller.step(Observation(0.0, q, np.full(7, speed)), Reference(arm.update(q, np.zeros(7)).pose))
    assert np.isfinite(output.command.torque).all()
    assert (np.abs(output.command.torque) <= arm.torque_limit).all()


class Silent:
    name = "silent"

    def solve(self, problem):
        return None


def test_where_the_solver_fails_gravity_is_held_and_motion_damped(arm, monkeypatch):
    monkeypatch.setattr(inverse_dynamics, "make_solver", lambda name: Silent())
    controller = OperationalSpaceController(arm)
    q, v = next(quiet_states(arm, 1))
    still = controller.step(Observation(0.0, q, 0.0 * v), nearby(arm.update(q, v)))
    np.testing.assert_allclose(still.command.torque, arm.update(q, 0.0 * v).h)
    np.testing.assert_allclose(still.acceleration, 0.0, atol=1e-9)
    assert "silent found no accelerations" in still.fallback
    moving = controller.step(Observation(0.0, q, v), nearby(arm.update(q, v)))
    assert v @ (moving.command.torque - arm.update(q, v).h) < 0.0
    wild = controller.step(Observation(0.0, q, 100.0 * np.ones(7)), nearby(arm.update(q, v)))
    assert (np.abs(wild.command.torque) <= arm.torque_limit).all()
    assert all(name.startswith("torque[") for name in wild.active_limits)
    assert wild.active_limits


def test_solvers_agree_with_and_without_active_limits(arm):
    home = HOME[arm.name]
    exact, splitting = (OperationalSpaceController(arm, posture=home, solver=name) for name in ("daqp", "osqp"))
    active = 0
    for q, v in random_states(arm, 40, seed=2):
        reference = nearby(arm.update(0.9 * q + 0.1 * home, v))
        one, other = (controller.step(Observation(0.0, q, v), reference) for controller in (exact, splitting))
        np.testing.assert_allclose(one.command.torque, other.command.torque, atol=1e-5)
        active += bool(one.active_limits)
    assert active > 0


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"gains": Impedance(500.0)}, TypeError, "MotionGains"),
        ({"solver": "gurobi"}, ConfigurationError, "gurobi"),
        ({"limits": ["torque", "power"]}, ConfigurationError, "no limit 'power'; the limits are torque"),
        ({"rate": 0.0}, ConfigurationError, "rate"),
        ({"posture": np.zeros(6)}, ConfigurationError, "6 entries"),
        ({"posture": np.full(7, np.nan)}, ValueError, "posture"),
    ],
)
def test_arguments_that_cannot_be_used_are_refused(arguments, error, message):
    with pytest.raises(error, match=message):
        OperationalSpaceController(load("panda"), **arguments)


def test_an_observation_that_is_not_finite_is_refused(arm):
    controller = OperationalSpaceController(arm)
    q = HOME[arm.name]
    with pytest.raises(ModelError, match="not finite"):
        controller.step(Observation(0.0, np.full(7, np.nan), q), Reference(arm.update(q, q).pose))


@pytest.mark.parametrize("posture", [np.zeros(6), np.full(7, np.nan)])
def test_a_posture_for_one_period_that_cannot_be_used_is_refused(arm, posture):
    q = HOME[arm.name]
    controller = OperationalSpaceController(arm)
    with pytest.raises(ConfigurationError, match="posture must be 7 finite numbers"):
        controller.step(Observation(0.0, q, 0.0 * q), Reference(arm.update(q, 0.0 * q).pose), posture=posture)
