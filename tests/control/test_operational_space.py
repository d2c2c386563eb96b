"""Operational-space control: its closed form, its accuracy on lines, masks, weights and postures."""

import numpy as np
import pinocchio as pin
import pytest

from arms import ARMS, HOME, load, nearby, quiet_states, random_states, simulate, without_friction
from khatib import least_squares_torque, operational_space_torque
from pilegrasp_ctrl.arm.model import ArmModel
from pilegrasp_ctrl.control.operational_space import OperationalSpaceController
from pilegrasp_ctrl.exceptions import ConfigurationError, GainsError, ModelError
from pilegrasp_ctrl.plant.arm_simulation import ArmSimulation
from pilegrasp_ctrl.plant.tracking import simulate_tracking
from pilegrasp_ctrl.robots import panda_urdf
from pilegrasp_ctrl.tasks.frame_task import FrameTask
from pilegrasp_ctrl.tasks.gains import Impedance, MotionGains
from pilegrasp_ctrl.tasks.pose_task import pose_error
from pilegrasp_ctrl.tasks.posture_task import PostureTask
from pilegrasp_ctrl.trajectories.straight_line import StraightLine
from pilegrasp_ctrl.types import Observation, Pose, Reference

GAINS = MotionGains([400.0] * 3 + [900.0] * 3)


@pytest.fixture(params=ARMS)
def arm(request):
    return load(request.param)


def wanted_by(gains, state, reference):
    task = FrameTask(state.arm, gains=gains)
    task.set_target(reference)
    return task.acceleration(state)


def test_the_torque_is_the_closed_form_if_no_limit_is_active(arm):
    home, weight, mask = HOME[arm.name], np.array([1, 2, 3, 1, 1, 0.5]), [1, 1, 1, 1, 0, 1]
    posture = PostureTask(arm, home, stiffness=50.0, weight=1e-3)
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


def test_the_torque_is_the_closed_form_anywhere_without_limits(arm):
    """The states cover the whole range, singular postures and high speeds; the task gives the wanted acceleration."""
    posture = PostureTask(arm, HOME[arm.name])
    controller = OperationalSpaceController(arm, GAINS, posture, limits=(), friction=False)
    for q, v in random_states(arm, 100, seed=5):
        state = arm.update(q, v)
        reference = nearby(state)
        output = controller.step(Observation(0.0, q, v), reference)
        expected = least_squares_torque(
            state,
            wanted_by(GAINS, state, reference),
            posture.stiffness * (HOME[arm.name] - q) - posture.damping * v,
            np.ones(6),
            posture.weight,
        )
        np.testing.assert_allclose(output.command.torque, expected, atol=1e-9)


def test_the_tool_s_acceleration_approaches_khatib_s_as_the_posture_weight_vanishes(arm):
    q, v = next(quiet_states(arm, 1))
    state = arm.update(q, v)
    reference = nearby(state)
    closed = operational_space_torque(state, wanted_by(GAINS, state, reference), np.linspace(-1.0, 1.0, arm.nv))
    gaps = []
    for weight in (1e-2, 1e-4, 1e-6):
        controller = OperationalSpaceController(
            arm, GAINS, PostureTask(arm, HOME[arm.name], weight=weight), friction=False
        )
        torque = controller.step(Observation(0.0, q, v), reference).command.torque
        gaps.append(np.abs(state.J @ np.linalg.solve(state.M, torque - closed)).max())
    assert gaps[0] < 1.0
    np.testing.assert_allclose(np.array(gaps[1:]) / gaps[:-1], 0.01, rtol=0.5)


def test_without_redundancy_the_torque_is_khatib_s():
    names = ["panda_finger_joint1", "panda_finger_joint2", "panda_joint3"]
    arm = ArmModel.from_urdf(panda_urdf(), "panda_hand_tcp", locked_joints=names)
    q, v = np.delete(HOME["panda"], 2), np.linspace(-0.1, 0.1, 6)
    state = arm.update(q, v)
    reference = nearby(state)
    controller = OperationalSpaceController(arm, GAINS, PostureTask(arm, q, weight=1e-12), friction=False)
    closed = operational_space_torque(state, wanted_by(GAINS, state, reference), np.zeros(6))
    np.testing.assert_allclose(controller.step(Observation(0.0, q, v), reference).command.torque, closed, atol=1e-6)


def test_khatib_s_torque_gives_the_wanted_tool_acceleration_for_any_posture_torque(arm):
    for q, v in quiet_states(arm, 3):
        state, wanted = arm.update(q, v), np.linspace(-1.0, 1.0, 6)
        for posture_torque in (np.zeros(arm.nv), np.linspace(-5.0, 5.0, arm.nv)):
            torque = operational_space_torque(state, wanted, posture_torque)
            a = np.linalg.solve(state.M, torque - state.h)
            np.testing.assert_allclose(state.J @ a + state.Jdot_v, wanted, atol=1e-9)


@pytest.mark.parametrize("name", ARMS)
def test_a_line_in_free_space_is_tracked(name):
    arm, q = without_friction(name), HOME[name]
    line = StraightLine(arm.update(q, np.zeros(7)).pose, [0.0, 0.2, 0.05], 0.25)
    motion = simulate_tracking(
        ArmSimulation(arm), OperationalSpaceController(arm, posture=q), line.at, q, line.duration + 0.1
    )
    assert np.linalg.norm(motion.error[:, :3], axis=1).max() < 1e-4
    assert np.linalg.norm(motion.error[:, 3:], axis=1).max() < 1e-4


@pytest.mark.slow
@pytest.mark.parametrize("displacement", [[0.0, 0.2, 0.05], [0.1, -0.15, 0.0], [0.0, 0.0, 0.15]])
@pytest.mark.parametrize("preferred", [False, True], ids=["no-posture", "posture"])
@pytest.mark.parametrize("name", ARMS)
def test_without_friction_the_tool_comes_to_rest_within_a_tenth_of_a_millimetre(name, preferred, displacement):
    """The remaining error is the pull of a posture that the tool does not allow: weight x acceleration / (K sigma)."""
    arm, home = without_friction(name), HOME[name]
    line = StraightLine(arm.update(home, np.zeros(7)).pose, displacement, 0.25)
    controller = OperationalSpaceController(arm, posture=home if preferred else None)
    *_, (_, q, v, _) = simulate(
        arm, lambda o: controller.step(o, line.at(o.time)).command.torque, home, line.duration + 1.0
    )
    error = pose_error(arm.update(q, v), Reference(line.end))
    assert np.linalg.norm(error[:3]) < (1e-4 if preferred else 1e-6)
    assert np.linalg.norm(error[3:]) < 1e-4


def worst(arm, line, reference, state=lambda state: state):
    """Return the largest position error [m] on a line for which the controller sees a changed reference or state."""
    controller, errors = OperationalSpaceController(arm, posture=HOME[arm.name]), []

    def step(observation):
        known = arm.update(observation.q, observation.v)
        errors.append(np.linalg.norm(pose_error(known, line.at(observation.time))[:3]))
        return controller.step(observation, reference(line.at(observation.time)), state=state(known)).command.torque

    for _ in simulate(arm, step, HOME[arm.name], line.duration):
        pass
    return max(errors)


@pytest.mark.parametrize("name", ARMS)
def test_each_feed_forward_removes_the_error_of_its_acceleration(name):
    """Without it the springs have to supply its acceleration, with errors D v / K = 2 v / sqrt(K) and a / K."""
    arm, speed, stiffness = without_friction(name), 0.25, 900.0
    line = StraightLine(arm.update(HOME[name], np.zeros(7)).pose, [0.0, 0.2, 0.05], speed)
    assert worst(arm, line, lambda at: at) < 1e-4
    assert worst(arm, line, lambda at: Reference(at.pose, acceleration=at.acceleration)) == pytest.approx(
        2.0 * speed / np.sqrt(stiffness), rel=0.1
    )
    peak = max(np.linalg.norm(line.at(time).acceleration[:3]) for time in np.linspace(0.0, line.duration, 200))
    assert 0.5 * peak / stiffness < worst(arm, line, lambda at: Reference(at.pose, at.twist)) < peak / stiffness


@pytest.mark.parametrize("name", ARMS)
def test_the_acceleration_jdot_v_of_moving_joints_is_compensated(name):
    """Without Jdot v the springs have to supply it: the error grows to Jdot v / K."""
    arm, home = without_friction(name), HOME[name]
    line = StraightLine(arm.update(home, np.zeros(7)).pose, [0.0, 0.35, 0.0], 0.6, acceleration=3.0)
    largest = 0.0

    def blind(state):
        nonlocal largest
        largest = max(largest, np.linalg.norm(state.Jdot_v[:3]))
        return state._replace(Jdot_v=np.zeros(6))

    assert worst(arm, line, lambda at: at) < 3e-4
    assert worst(arm, line, lambda at: at, blind) == pytest.approx(largest / 900.0, rel=0.1)


@pytest.mark.parametrize("axis", [2, 5])
def test_a_masked_axis_is_free(arm, axis):
    plant, home = without_friction(arm.name), HOME[arm.name]
    start = plant.update(home, np.zeros(7)).pose
    turn = pin.exp3(np.array([0.0, 0.0, 0.3]))
    far = start.moved([0.0, 0.0, 0.1]) if axis == 2 else Pose(start.translation, turn @ start.rotation)
    controller = OperationalSpaceController(plant, mask=np.arange(6) != axis)
    still = Observation(0.0, home, np.zeros(7))
    one, other = (controller.step(still, Reference(pose)).command.torque for pose in (start, far))
    np.testing.assert_allclose(one, other, atol=1e-9)
    push = np.eye(6)[axis] * (5.0 if axis == 2 else 0.02)

    def offsets(controller):
        """Return the tool's offset at the end of the push, after 0.2 s, and 0.6 s later."""
        time = 0.0

        def step(observation):
            nonlocal time
            time = observation.time
            return controller.step(observation, Reference(start)).command.torque

        def external(q, v):
            return plant.update(q, v).J.T @ push if time < 0.2 else np.zeros(7)

        run = list(simulate(plant, step, home, 0.8, external=external))
        return [pose_error(plant.update(q, v), Reference(start)) for _, q, v, _ in (run[100], run[-1])]

    pushed, left = offsets(controller)
    assert abs(left[axis]) > max(1e-3, 0.9 * abs(pushed[axis]))
    assert np.abs(np.delete(left, axis)).max() < 1e-4
    pushed, left = offsets(OperationalSpaceController(plant))
    assert abs(pushed[axis]) > 1e-4
    assert np.abs(left).max() < 1e-4


@pytest.mark.parametrize("angle", [np.pi / 2, np.pi, 1.1 * np.pi])
@pytest.mark.parametrize("name", ARMS)
def test_a_large_rotation_error_does_not_move_the_tool_far(name, angle):
    """An unbounded spring of 1600 x pi would use up the arm's limits, and the tool would stray by 0.6 m."""
    arm, home = without_friction(name), HOME[name]
    start = arm.update(home, np.zeros(7)).pose
    turned = Reference(Pose(start.translation, pin.exp3(np.array([0.0, 0.0, angle])) @ start.rotation))
    controller, errors, fallbacks = OperationalSpaceController(arm), [], []

    def step(observation):
        output = controller.step(observation, turned)
        fallbacks.append(output.fallback)
        return output.command.torque

    for _, q, v, _ in simulate(arm, step, home, 2.5):
        errors.append(pose_error(arm.update(q, v), turned))
    assert not any(fallbacks)
    assert np.linalg.norm(np.array(errors)[:, :3], axis=1).max() < 0.03
    assert np.linalg.norm(errors[-1]) < 1e-4


def test_the_arm_takes_its_posture_without_moving_the_tool():
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


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"gains": Impedance(500.0)}, GainsError, "MotionGains"),
        ({"solver": "gurobi"}, ConfigurationError, "gurobi"),
        ({"limits": ["torque", "power"]}, ConfigurationError, "no limit 'power'; the limits are torque"),
        ({"rate": 0.0}, ConfigurationError, "rate"),
        ({"posture": np.zeros(6)}, ConfigurationError, "must be 7 finite numbers"),
        ({"posture": np.full(7, np.nan)}, ConfigurationError, "must be 7 finite numbers"),
    ],
)
def test_arguments_that_cannot_be_used_are_rejected(arguments, error, message):
    with pytest.raises(error, match=message):
        OperationalSpaceController(load("panda"), **arguments)


def test_an_observation_that_is_not_finite_is_rejected(arm):
    controller = OperationalSpaceController(arm)
    q = HOME[arm.name]
    with pytest.raises(ModelError, match="not finite"):
        controller.step(Observation(0.0, np.full(7, np.nan), q), Reference(arm.update(q, q).pose))


@pytest.mark.parametrize("posture", [np.zeros(6), np.full(7, np.nan)])
def test_a_posture_for_one_period_that_cannot_be_used_is_rejected(arm, posture):
    q = HOME[arm.name]
    controller = OperationalSpaceController(arm)
    with pytest.raises(ConfigurationError, match="target of the PostureTask must be 7 finite numbers"):
        controller.step(Observation(0.0, q, 0.0 * q), Reference(arm.update(q, 0.0 * q).pose), posture=posture)
