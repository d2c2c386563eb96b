"""Each kind of task does what it says, in a list with others, on both arms."""

import numpy as np
import pinocchio as pin
import pytest

import pilegrasp_ctrl as pg
from arms import ARMS, HOME, load, random_states, without_friction
from pilegrasp_ctrl.tasks.pose_task import pose_error

LINK = {"wam7": "link4", "panda": "panda_link4"}
WRIST = {"wam7": "link6", "panda": "panda_link6"}


@pytest.fixture(params=ARMS)
def arm(request):
    return without_friction(request.param)


def run(controller, arm, q, duration, each=lambda time: None, plant=None):
    """The samples of a run; `each(time)` sets targets before each period."""

    def torque(observation):
        each(observation.time)
        output = controller.step(observation)
        assert output.fallback == ""
        return output.command.torque

    return list((plant or pg.ArmSimulation(arm)).run(torque, q, duration))


def state_after(arm, samples):
    return arm.update(samples[-1].q, samples[-1].v)


def test_a_frame_task_moves_any_frame_and_two_frames_at_once(arm):
    q = HOME[arm.name]
    start = arm.update(q, 0.0 * q)
    elbow_start = start.frame(LINK[arm.name]).pose
    tool, elbow = pg.FrameTask(arm), pg.FrameTask(arm, LINK[arm.name], mask=[1, 0, 0, 0, 0, 0], weight=0.1)
    tool.set_target(start.pose)
    elbow.set_target(elbow_start.moved([0.0, 0.0, 0.0]))
    controller = pg.InverseDynamics(arm, [tool, elbow, pg.DampingTask(arm)])
    # The elbow swings about the line from shoulder to wrist; the tool stays.
    elbow.mask = [0, 1, 0, 0, 0, 0]
    elbow.set_target(elbow_start.moved([0.0, 0.05, 0.0]))
    end = state_after(arm, run(controller, arm, q, 2.0))
    assert np.abs(pose_error(end, pg.Reference(start.pose))).max() < 1e-4
    assert end.frame(LINK[arm.name]).translation[1] == pytest.approx(elbow_start.translation[1] + 0.05, abs=1e-3)


def test_the_rows_of_a_relative_frame_are_its_second_derivative(arm):
    task = pg.RelativeFrameTask(arm, None, LINK[arm.name])
    for q, v in random_states(arm, 5):
        a, h = np.linspace(-1.0, 1.0, arm.nv), 1e-4

        def relative(t, q=q, v=v, a=a):
            state = arm.update(q + t * v + 0.5 * t * t * a, v + t * a)
            return state.frame(LINK[arm.name]).pose.inverse() @ state.pose

        view = task.view(arm.update(q, v))
        before, now, after = relative(-h), relative(0.0), relative(h)
        np.testing.assert_allclose(view.translation, now.translation, atol=1e-12)
        np.testing.assert_allclose(view.rotation, now.rotation, atol=1e-12)
        velocity = (after.translation - before.translation) / (2.0 * h)
        np.testing.assert_allclose(view.twist[:3], velocity, atol=1e-5)
        spin = pin.log3(after.rotation @ before.rotation.T) / (2.0 * h)
        np.testing.assert_allclose(view.twist[3:], spin, atol=1e-5)
        np.testing.assert_allclose(view.J @ v, view.twist, atol=1e-9)
        acceleration = (after.translation - 2.0 * now.translation + before.translation) / h**2
        np.testing.assert_allclose((view.J @ a + view.Jdot_v)[:3], acceleration, atol=1e-4)
        turn = pin.log3(after.rotation @ now.rotation.T) - pin.log3(now.rotation @ before.rotation.T)
        np.testing.assert_allclose((view.J @ a + view.Jdot_v)[3:], turn / h**2, atol=1e-4)


def test_a_relative_frame_task_keeps_a_pose_as_seen_from_a_moving_link(arm):
    q, root = HOME[arm.name], LINK[arm.name]
    start = arm.update(q, 0.0 * q)
    seen = start.frame(root).pose.inverse() @ start.pose
    held = pg.RelativeFrameTask(arm, None, root)
    held.set_target(seen)
    swing = pg.JointTask(arm, q[:2] + np.array([0.4, -0.3]), joints=arm.joint_names[:2])
    end = state_after(arm, run(pg.InverseDynamics(arm, [held, swing]), arm, q, 3.0))
    np.testing.assert_allclose(end.q[:2], q[:2] + np.array([0.4, -0.3]), atol=1e-3)
    now = end.frame(root).pose.inverse() @ end.pose
    np.testing.assert_allclose(now.translation, seen.translation, atol=1e-3)
    np.testing.assert_allclose(now.rotation, seen.rotation, atol=1e-3)


@pytest.mark.parametrize("turned", [0.0, 1.0, np.pi])
def test_an_axis_task_aligns_its_axis_and_leaves_the_turn_about_it_free(arm, turned):
    q = HOME[arm.name]
    start = arm.update(q, 0.0 * q)
    axis = np.array([0.0, 0.6, 0.8])
    away = np.cross(start.rotation @ axis, [1.0, 0.0, 0.3])
    direction = pin.exp3(turned * away / np.linalg.norm(away)) @ start.rotation @ axis
    task = pg.AxisTask(arm, axis, direction)
    state = arm.update(q, np.linspace(-0.2, 0.2, arm.nv))
    rows = task.rows(state)
    assert np.linalg.matrix_rank(rows.A, tol=1e-9) == 2
    about = np.linalg.lstsq(state.J[3:], state.rotation @ axis, rcond=None)[0]
    np.testing.assert_allclose(rows.A @ about, 0.0, atol=1e-9)
    if turned <= 1.0:
        run_task = pg.AxisTask(arm, axis, direction)
        end = state_after(arm, run(pg.InverseDynamics(arm, [run_task, pg.DampingTask(arm)]), arm, q, 3.0))
        np.testing.assert_allclose(end.rotation @ axis, direction, atol=2e-3)


def test_an_axis_half_a_turn_away_is_turned_to_one_side(arm):
    state = arm.update(HOME[arm.name], np.zeros(arm.nv))
    for axis in np.eye(3):
        task = pg.AxisTask(arm, axis, -state.rotation @ axis)
        rows = task.rows(state)
        assert np.isfinite(rows.b).all()
        assert np.linalg.norm(rows.b) == pytest.approx(40.0 * 3.0)


def test_joints_go_to_a_far_posture_at_the_speed_that_is_allowed(arm):
    q = HOME[arm.name]
    goal = q + 0.5 * np.where(np.arange(arm.nv) % 2, -1.0, 1.0)
    controller = pg.InverseDynamics(arm, [pg.JointTask(arm, goal, max_speed=0.4)])
    samples = run(controller, arm, q, 3.0)
    np.testing.assert_allclose(samples[-1].q, goal, atol=1e-3)
    fastest = np.abs([sample.v for sample in samples]).max(axis=0)
    assert ((fastest > 0.35) & (fastest < 0.41)).all()


def test_joints_with_an_impedance_yield_by_torque_over_stiffness_and_return(arm):
    q, stiffness = HOME[arm.name], np.geomspace(60.0, 2.0, arm.nv)
    push = 0.05 * stiffness
    task = pg.JointTask(arm, q, pg.JointImpedance(stiffness), weight=1.0)
    controller = pg.InverseDynamics(arm, [task])

    class Pushed(pg.ArmSimulation):
        pushing = True

        def external(self, q, v):
            return push if self.pushing else None

    plant = Pushed(arm)
    pushed = run(controller, arm, q, 4.0, plant=plant)
    np.testing.assert_allclose(pushed[-1].q - q, 0.05, atol=2e-3)
    plant.pushing = False
    controller.reset()
    back = run(controller, arm, pushed[-1].q, 4.0, plant=plant)
    np.testing.assert_allclose(back[-1].q, q, atol=2e-3)


def test_without_stiffness_a_hand_guides_the_arm_and_it_stays_where_it_is_left(arm):
    q = HOME[arm.name]
    dampers = pg.JointImpedance(0.0, damping=[8.0, 8.0, 4.0, 4.0, 0.5, 0.5, 0.05])
    controller = pg.InverseDynamics(arm, [pg.JointTask(arm, stiffness=dampers)])

    class Guided(pg.ArmSimulation):
        hand = 8.0 * np.eye(7)[3]

        def external(self, q, v):
            return self.hand

    plant = Guided(arm)
    guided = run(controller, arm, q, 0.5, plant=plant)
    assert abs(guided[-1].q[3] - q[3]) > 0.02
    plant.hand = np.zeros(7)
    controller.reset()
    left = list(plant.run(lambda o: controller.step(o).command.torque, guided[-1].q, 1.5, v=guided[-1].v))
    assert np.abs(left[-1].v).max() < 0.05
    rest = list(plant.run(lambda o: controller.arm.update(o.q, o.v).h, left[-1].q, 0.1))
    np.testing.assert_allclose(rest[-1].q, left[-1].q, atol=1e-3)


def test_a_coupling_holds_a_linear_relation_while_other_tasks_move_the_joints(arm):
    q = HOME[arm.name]
    first, third = arm.joint_names[0], arm.joint_names[2]
    value = q[0] + 2.0 * q[2]
    coupling = pg.CouplingTask(arm, {first: 1.0, third: 2.0}, value)
    moving = pg.JointTask(arm, [q[0] + 0.4], joints=[first])
    samples = run(pg.InverseDynamics(arm, [coupling, moving]), arm, q, 2.0)
    relation = [sample.q[0] + 2.0 * sample.q[2] for sample in samples]
    np.testing.assert_allclose(relation, value, atol=1e-3)
    assert samples[-1].q[0] == pytest.approx(q[0] + 0.4, abs=1e-2)


def test_motion_that_the_tasks_leave_free_dies_out(arm):
    q, v = HOME[arm.name], 0.2 * np.linspace(-1.0, 1.0, arm.nv)
    controller = pg.InverseDynamics(arm, [pg.FrameTask(arm, mask=[1, 1, 1, 0, 0, 0])])
    assert isinstance(controller.tasks[-1], pg.DampingTask)
    controller.tasks[0].set_target(arm.update(q, 0.0 * q).pose)
    samples = list(pg.ArmSimulation(arm).run(lambda o: controller.step(o).command.torque, q, 1.5, v=v))
    assert np.abs(samples[-1].v).max() < 1e-3


def test_thirty_circles_drift_without_a_posture_and_not_with_one(arm):
    q, period = HOME[arm.name], 1.0
    start = arm.update(q, 0.0 * q).pose

    def circle(time):
        angle = 2.0 * np.pi * time / period
        w, r = 2.0 * np.pi / period, 0.1
        # Starts at rest: the radius grows within the first turn.
        grow = min(1.0, time / period)
        shift = r * grow * np.array([0.0, np.sin(angle), 1.0 - np.cos(angle)])
        speed = r * grow * w * np.array([0.0, np.cos(angle), np.sin(angle)])
        return pg.Reference(start.moved(shift), np.concatenate((speed, np.zeros(3))))

    def drift(posture):
        controller = pg.OperationalSpaceController(arm, posture=posture)
        *_, last = pg.ArmSimulation(arm).run(lambda o: controller.step(o, circle(o.time)).command.torque, q, 8.0)
        return np.abs(last.q - q).max()

    assert drift(q) < 0.3 * drift(None)


def test_weights_masks_gains_and_targets_can_be_set_while_it_runs(arm):
    q = HOME[arm.name]
    state, tool = arm.update(q, 0.0 * q), pg.FrameTask(arm)
    controller = pg.InverseDynamics(arm, [tool, pg.PostureTask(arm, q)])
    tool.set_target(state.pose.moved([0.01, 0.01, 0.0]))
    observation = pg.Observation(0.0, q, 0.0 * q)

    def tool_acceleration():
        controller.reset()
        return (state.J @ controller.step(observation).acceleration)[:3]

    np.testing.assert_allclose(tool_acceleration(), [9.0, 9.0, 0.0], atol=0.05)
    tool.gains = pg.MotionGains(100.0)
    np.testing.assert_allclose(tool_acceleration(), [1.0, 1.0, 0.0], atol=0.05)
    tool.mask = [0, 1, 1, 1, 1, 1]
    assert abs(tool_acceleration()[0]) < 0.5
    tool.mask, tool.weight = None, [1e-9, 1, 1, 1, 1, 1]
    assert abs(tool_acceleration()[0]) < 0.5
    tool.weight = 1.0
    tool.set_target(state.pose.moved([0.0, 0.0, 0.02]))
    np.testing.assert_allclose(tool_acceleration(), [0.0, 0.0, 2.0], atol=0.05)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda arm: pg.FrameTask("wam7"), "takes the arm first"),
        (lambda arm: pg.PostureTask(np.zeros(7)), "takes the arm first"),
        (lambda arm: pg.FrameTask(arm, "no_link"), "no frame 'no_link'"),
        (lambda arm: pg.FrameTask(arm, mask=[0] * 6), "no axis"),
        (lambda arm: pg.FrameTask(arm, mask=[1, 1]), "six booleans"),
        (lambda arm: pg.FrameTask(arm, weight="heavy"), "one number or six"),
        (lambda arm: pg.FrameTask(arm, max_speed=0.0), "max_speed"),
        (lambda arm: pg.FrameTask(arm, gains=400.0), "MotionGains in 1/s²"),
        (lambda arm: pg.FrameTask(arm).set_target([0.0, 0.0, 0.0]), "a Reference or a Pose, not list"),
        (lambda arm: pg.RelativeFrameTask(arm, None, arm.tool_frame), "name another root"),
        (lambda arm: pg.AxisTask(arm, [0.0, 0.0, 0.0]), "not all zero"),
        (lambda arm: pg.AxisTask(arm, [0.0, 0.0, 1.0]).rows(arm.update(np.zeros(7), np.zeros(7))), "no direction"),
        (lambda arm: pg.JointTask(arm, np.zeros(6)), "7 finite numbers"),
        (lambda arm: pg.JointTask(arm, [0.0], joints=["elbow"]), "different names of"),
        (lambda arm: pg.JointTask(arm, [0.0], joints="elbow"), "different names of"),
        (lambda arm: pg.JointTask(arm, np.zeros(7), -1.0), "not negative"),
        (lambda arm: pg.JointTask(arm, np.zeros(7), weight=0.0), "weight"),
        (lambda arm: pg.CouplingTask(arm, {"elbow": 1.0}), "different names of"),
        (lambda arm: pg.CouplingTask(arm, {arm.joint_names[0]: 0.0}), "not all zero"),
        (lambda arm: pg.CouplingTask(arm, [1.0]), "map names of joints"),
        (lambda arm: pg.DampingTask(arm, -1.0), "not negative"),
    ],
)
def test_a_task_that_cannot_be_made_says_why_in_one_sentence(make, message):
    with pytest.raises(pg.PilegraspError, match=message) as raised:
        make(load("wam7"))
    assert "\n" not in str(raised.value)
