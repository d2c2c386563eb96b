"""Arms of published packages track a line of 0.2 m within 0.2 mm, from a posture that a rule chooses."""

import pytest

from arm_table import row_of
from published_arms import example_arms, mujoco_arms

ARMS = {arm.name: arm for arm in (*example_arms()[0], *mujoco_arms())}
QUICK = ("kinova", "xarm7", "UR5e of MuJoCo Menagerie", "OpenArm, right arm", "Fetch")


def test_the_rule_finds_the_arms_of_the_package_and_leaves_out_walking_robots():
    arms, others = example_arms()
    names = {arm.name for arm in arms}
    assert {"panda", "kinova", "ur5_robot", "xarm7", "z1", "so100", "talos_left_arm", "tiago_no_hand"} <= names
    assert {"a1", "solo12", "bolt", "romeo", "pr2", "double_pendulum"} <= set(others)
    assert {arm.joints for arm in arms} <= set(range(3, 14))


@pytest.mark.filterwarnings("ignore::pilegrasp_ctrl.exceptions.ModelWarning")
@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[] if name in QUICK else [pytest.mark.slow]) for name in ARMS],
)
def test_an_arm_tracks_a_line(name):
    assert row_of(ARMS[name])[-1] == "tracks"
