"""Parts of the simulated world: what counts as held, the start posture, the layout and the backend."""

from itertools import product

import mink
import mujoco
import numpy as np
import pytest

from pilegrasp_ctrl.arm.model import ArmModel
from pilegrasp_ctrl.config import PileConfig, SupportConfig, load_scenario
from pilegrasp_ctrl.exceptions import UnreachablePoseError
from pilegrasp_ctrl.planning.layout import (
    BASE_BELOW_TABLE,
    CORNER_DISTANCE,
    WALL_DISTANCE,
    WALL_HALF_HEIGHT,
    make_layout,
)
from pilegrasp_ctrl.planning.strategy import tool_rotation
from pilegrasp_ctrl.programs.attempt import prepare
from pilegrasp_ctrl.robots import path
from pilegrasp_ctrl.sim.hand import Hand
from pilegrasp_ctrl.sim.start_posture import MARGIN, ORIENTATION_TOLERANCE, POSITION_TOLERANCE, StartPosture
from pilegrasp_ctrl.types import Pose

BASE = make_layout(SupportConfig(), PileConfig(), 0.054).transform_base_to_world
PLACES = [(0.55, -0.15, 0.25), (0.65, 0.0, 0.22), (0.75, 0.1, 0.06), (0.85, 0.0, 0.0)]


@pytest.fixture(scope="module", params=["rbo_hand2", "shovel"])
def search(request):
    hand = Hand.load(request.param)
    tool = hand.transform_tool_to_flange
    return (
        hand,
        StartPosture("wam7", tool, BASE),
        ArmModel.load("wam7", tool_frame=tool, base=BASE),
        mujoco.MjModel.from_xml_path(str(path("wam7", "wam7.xml"))),
    )


def angle(first, second):
    return np.arccos(np.clip(0.5 * (np.trace(first.T @ second) - 1.0), -1.0, 1.0))


@pytest.mark.parametrize("place", PLACES)
def test_both_engines_put_the_tool_where_it_was_asked_for(search, place):
    hand, posture, arm, model = search
    asked = Pose(place, tool_rotation(0.1, hand.theta))
    q = posture.solve(asked)
    data = mujoco.MjData(model)
    data.qpos[:] = q
    mujoco.mj_forward(model, data)
    flange = data.site("flange")
    by_mujoco = BASE @ Pose(flange.xpos, flange.xmat.reshape(3, 3)) @ hand.transform_tool_to_flange
    by_pinocchio = arm.update(q, np.zeros(7)).pose
    for pose in (by_mujoco, by_pinocchio):
        assert np.linalg.norm(pose.translation - asked.translation) < POSITION_TOLERANCE + 1e-6
        assert angle(pose.rotation, asked.rotation) < ORIENTATION_TOLERANCE + 1e-6
    margin = np.minimum(q - arm.q_lower, arm.q_upper - q)
    assert margin.min() > MARGIN - 1e-3


def test_a_start_leads_to_a_posture_near_it(search):
    hand, posture, *_ = search
    here = Pose((0.7, 0.0, 0.1), tool_rotation(0.0, hand.theta))
    first = posture.solve(here)
    other = posture.solve(here, first + np.array([-0.3, 0.1, 0.4, 0.0, 0.2, 0.1, 0.0]))
    assert np.abs(other - first).max() > 0.2
    for q in (first, other):
        np.testing.assert_allclose(posture.solve(here, q), q, atol=1e-3)
        assert np.abs(posture.solve(here.moved([0.02, 0.0, 0.0]), q) - q).max() < 0.15


def test_a_straight_way_ends_next_to_its_start_or_nowhere(search):
    hand, posture, arm, _ = search
    here = Pose((0.7, 0.0, 0.1), tool_rotation(0.0, hand.theta))
    q = posture.solve(here)
    np.testing.assert_allclose(posture.solve_near(here.moved([0.02, 0.0, 0.0]), q), q, atol=0.15)
    with pytest.raises(UnreachablePoseError, match="cannot reach"):
        posture.solve_near(here.moved([0.8, 0.0, 0.0]), q)
    # The search finds a posture of its own where none lies next to the start.
    rng, nowhere = np.random.default_rng(0), 0
    for start in rng.uniform(arm.q_lower, arm.q_upper, (8, 7)):
        assert np.isfinite(posture.solve(here, start)).all()
        try:
            posture.solve_near(here, start)
        except UnreachablePoseError:
            nowhere += 1
    assert 0 < nowhere < 8


def test_the_search_ends_when_the_joints_have_come_to_rest(search, monkeypatch):
    hand, posture, *_ = search
    here = Pose((0.7, 0.0, 0.1), tool_rotation(0.0, hand.theta))
    q, calls, once = posture.solve(here), [], mink.solve_ik
    monkeypatch.setattr(mink, "solve_ik", lambda *args, **options: calls.append(1) or once(*args, **options))
    posture.solve(here.moved([0.02, 0.0, 0.0]), q)
    assert 1 < len(calls) < 20


@pytest.mark.parametrize("place", [(1.5, 0.0, 0.3), (0.7, 0.0, -0.9)])
def test_a_place_out_of_reach_is_said_in_one_sentence(search, place):
    hand, posture, *_ = search
    with pytest.raises(UnreachablePoseError, match="cannot reach") as error:
        posture.solve(Pose(place, tool_rotation(0.0, hand.theta)))
    assert "\n" not in str(error.value)
    assert "({:.2f}, {:.2f}, {:.2f}) m".format(*place) in str(error.value)


def layout_of(support):
    return make_layout(SupportConfig(kind=support), PileConfig(), 0.054)


def normal_of(wall):
    return np.array([np.cos(wall.yaw), np.sin(wall.yaw)])


def test_walls_stand_on_the_table_and_face_the_pile():
    assert layout_of("none").walls == ()
    (wall,) = layout_of("wall").walls
    np.testing.assert_allclose(normal_of(wall), [-1.0, 0.0], atol=1e-12)
    corner = layout_of("corner").walls
    np.testing.assert_allclose(sorted(normal_of(wall)[1] for wall in corner), [-np.sqrt(0.5), np.sqrt(0.5)])
    for layout in (layout_of("wall"), layout_of("corner")):
        half = 0.5 * layout.frame_size
        turn = np.array([[np.cos(layout.frame_yaw), -np.sin(layout.frame_yaw)],
                         [np.sin(layout.frame_yaw), np.cos(layout.frame_yaw)]])  # fmt: skip
        frame = layout.frame_center + np.array(list(product((-half, half), repeat=2))) @ turn.T
        for wall in layout.walls:
            assert wall.center[2] == wall.half_size[2] == WALL_HALF_HEIGHT
            depth = (frame - wall.center[:2]) @ normal_of(wall) - wall.half_size[0]
            assert depth.min() == pytest.approx(0.0, abs=1e-9)
            along = (frame - wall.center[:2]) @ [-normal_of(wall)[1], normal_of(wall)[0]]
            assert np.abs(along).max() <= wall.half_size[1] + 1e-9


def test_the_inner_faces_are_where_the_distances_say():
    (wall,) = layout_of("wall").walls
    assert wall.center[0] - wall.half_size[0] == pytest.approx(WALL_DISTANCE)
    apex = np.array([CORNER_DISTANCE, 0.0])
    for wall in layout_of("corner").walls:
        assert (apex - wall.center[:2]) @ normal_of(wall) == pytest.approx(wall.half_size[0])
    left, right = layout_of("corner").walls
    np.testing.assert_allclose(left.center * [1, -1, 1], right.center, atol=1e-12)
    assert left.center[1] > 0.0


def test_the_table_is_above_the_arms_base():
    base = layout_of("wall").transform_base_to_world
    np.testing.assert_array_equal(base.translation, [0.0, 0.0, -BASE_BELOW_TABLE])
    np.testing.assert_array_equal(base.rotation, np.eye(3))


@pytest.fixture(scope="module")
def backend(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
        attempt = prepare(load_scenario("spheres_wall", {"pile.count": 2}), seed=0)
    return attempt.simulation, attempt.arm, attempt.simulation.observe().q.copy()


POSES = np.array([[0.9, 0.1, 0.027, 1.0, 0.0, 0.0, 0.0], [0.9, -0.1, 0.027, 0.0, 1.0, 0.0, 0.0]])


def test_reset_puts_everything_in_its_place_at_rest(backend):
    simulation, _, q = backend
    simulation.reset(q, POSES)
    observation = simulation.observe()
    np.testing.assert_array_equal(observation.q, q)
    np.testing.assert_array_equal(observation.v, 0.0)
    assert observation.time == 0.0
    position, quaternion = simulation.poses(np.array(simulation.scene.objects))
    np.testing.assert_allclose(position, POSES[:, :3])
    np.testing.assert_allclose(quaternion, POSES[:, 3:])
    assert not simulation.data.ctrl.any()


def test_a_step_is_a_control_period_and_gravitys_torque_holds_the_arm(backend):
    simulation, arm, q = backend
    simulation.reset(q, POSES)
    before = simulation.observe()
    simulation.apply(arm.update(q, np.zeros(7)).h, 0.0)
    for _ in range(50):
        simulation.step()
    after = simulation.observe()
    assert after.time == pytest.approx(0.1)
    np.testing.assert_allclose(after.q, q, atol=2e-3)
    np.testing.assert_array_equal(before.q, q)
    assert (before.time, np.abs(before.v).max()) == (0.0, 0.0)


@pytest.mark.parametrize("joint", range(7))
def test_a_torque_turns_its_joint_the_positive_way(backend, joint):
    simulation, arm, q = backend
    simulation.reset(q, POSES)
    torque = arm.update(q, np.zeros(7)).h.copy()
    torque[joint] += 2.0 * arm.friction_coulomb[joint] + 0.2
    simulation.apply(torque, 0.0)
    for _ in range(10):
        simulation.step()
    assert simulation.observe().v[joint] > 1e-3


def test_the_closure_reaches_every_finger_and_no_joint_of_the_arm(backend):
    simulation, _, q = backend
    simulation.reset(q, POSES)
    torque = np.arange(1.0, 8.0)
    simulation.apply(torque, 0.6)
    np.testing.assert_array_equal(simulation.data.ctrl, [*torque, *[0.6] * 5])


def test_after_a_reset_the_motion_is_the_same_to_the_last_bit(backend):
    simulation, arm, q = backend
    ends = []
    for _ in range(2):
        simulation.reset(q, POSES)
        simulation.apply(0.9 * arm.update(q, np.zeros(7)).h, 0.5)
        for _ in range(50):
            simulation.step()
        ends.append((simulation.data.qpos.copy(), simulation.data.qvel.copy()))
    np.testing.assert_array_equal(ends[0][0], ends[1][0])
    np.testing.assert_array_equal(ends[0][1], ends[1][1])


def test_poses_are_copies(backend):
    simulation, _, q = backend
    simulation.reset(q, POSES)
    position, _ = simulation.poses(np.array(simulation.scene.objects))
    kept = position.copy()
    for _ in range(5):
        simulation.data.qvel[-12:] = 0.3
        simulation.step()
    np.testing.assert_array_equal(position, kept)
