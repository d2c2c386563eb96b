"""Joint angles for a tool pose: within limits, near a start, and in agreement between both engines."""

import mink
import mujoco
import numpy as np
import pytest

from pilegrasp_ctrl.arm.model import ArmModel
from pilegrasp_ctrl.config import PileConfig, SupportConfig
from pilegrasp_ctrl.exceptions import UnreachablePoseError
from pilegrasp_ctrl.planning.layout import make_layout
from pilegrasp_ctrl.planning.strategy import tool_rotation
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
def test_both_engines_put_the_tool_at_the_pose_that_was_asked_for(search, place):
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


def test_a_posture_is_rounded_far_beyond_what_blas_changes_from_one_processor_to_another(search):
    hand, posture, *_ = search
    q = posture.solve(Pose((0.7, 0.0, 0.1), tool_rotation(0.0, hand.theta)))
    np.testing.assert_array_equal(q, np.round(q, 6))


def test_a_start_leads_to_a_posture_near_it(search):
    hand, posture, *_ = search
    here = Pose((0.7, 0.0, 0.1), tool_rotation(0.0, hand.theta))
    first = posture.solve(here)
    other = posture.solve(here, first + np.array([-0.3, 0.1, 0.4, 0.0, 0.2, 0.1, 0.0]))
    assert np.abs(other - first).max() > 0.2
    for q in (first, other):
        np.testing.assert_allclose(posture.solve(here, q), q, atol=1e-3)
        assert np.abs(posture.solve(here.moved([0.02, 0.0, 0.0]), q) - q).max() < 0.15


def test_a_straight_motion_ends_next_to_its_start_or_is_rejected(search):
    hand, posture, arm, _ = search
    here = Pose((0.7, 0.0, 0.1), tool_rotation(0.0, hand.theta))
    q = posture.solve(here)
    np.testing.assert_allclose(posture.solve_near(here.moved([0.02, 0.0, 0.0]), q), q, atol=0.15)
    with pytest.raises(UnreachablePoseError, match="cannot reach"):
        posture.solve_near(here.moved([0.8, 0.0, 0.0]), q)
    # The full search finds another posture if there is none near the start.
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
def test_a_pose_out_of_reach_is_rejected_in_one_sentence(search, place):
    hand, posture, *_ = search
    with pytest.raises(UnreachablePoseError, match="cannot reach") as error:
        posture.solve(Pose(place, tool_rotation(0.0, hand.theta)))
    assert "\n" not in str(error.value)
    assert "({:.2f}, {:.2f}, {:.2f}) m".format(*place) in str(error.value)
