"""An arm loads from a folder of the user's own, whose `robot.toml` adds what the model lacks."""

import numpy as np
import pytest

from pilegrasp_ctrl import ArmModel
from pilegrasp_ctrl.exceptions import ModelError
from pilegrasp_ctrl.robots import panda_urdf, path

PANDA = """
[robot]
urdf = "panda.urdf"
flange_frame = "panda_link8"

[joints]
names = ["panda_joint1", "panda_joint2", "panda_joint3", "panda_joint4", "panda_joint5", "panda_joint6", "panda_joint7"]
friction_coulomb = [1.0, 1.0, 1.0, 1.0, 0.5, 0.5, 0.5]
locked = { panda_finger_joint1 = 0.02 }
"""


@pytest.fixture
def folder(tmp_path):
    made = tmp_path / "my_panda"
    made.mkdir()
    (made / "panda.urdf").write_bytes(panda_urdf().read_bytes())
    (made / "robot.toml").write_text(PANDA)
    return made


def test_a_folder_with_a_urdf_is_an_arm(folder):
    for place in (folder, str(folder)):
        arm = ArmModel.load(place)
        assert repr(arm) == "ArmModel('my_panda', nv=7, tool_frame='panda_link8')"
        assert arm.friction_coulomb.tolist() == [1.0, 1.0, 1.0, 1.0, 0.5, 0.5, 0.5]
        np.testing.assert_array_equal(arm.torque_limit, [87.0, 87.0, 87.0, 87.0, 12.0, 12.0, 12.0])


def test_a_folder_with_an_mjcf_is_an_arm(tmp_path):
    text = path("wam7", "robot.toml").read_text().replace('urdf = "wam7.urdf"', "")
    (tmp_path / "robot.toml").write_text(text)
    (tmp_path / "wam7.xml").write_bytes(path("wam7", "wam7.xml").read_bytes())
    arm, shipped = ArmModel.load(tmp_path), ArmModel.load("wam7")
    np.testing.assert_array_equal(arm.velocity_limit, shipped.velocity_limit)
    np.testing.assert_array_equal(arm.joint_to_motor, shipped.joint_to_motor)
    q = np.linspace(-0.5, 0.5, 7)
    np.testing.assert_allclose(arm.update(q, q).h, shipped.update(q, q).h, atol=1e-9)


def test_an_argument_stands_in_place_of_what_the_folder_says(folder):
    arm = ArmModel.load(folder, velocity_limit=np.ones(7), friction_coulomb=np.zeros(7))
    assert arm.velocity_limit.tolist() == [1.0] * 7
    assert not arm.friction_coulomb.any()


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('urdf = "panda.urdf"', 'urdf = "robot.urdf"', r"robot\.urdf: no such URDF or MJCF file"),
        ('urdf = "panda.urdf"', "", "robot.toml has no key 'mjcf', so it is not an arm; add the key"),
        ('flange_frame = "panda_link8"', "", "robot.toml has no key 'flange_frame', so it is not an arm"),
        ("panda_link8", "flange", "no frame 'flange' for the tool; the links are panda_link0"),
        ("[robot]", "robot = 1\n[robots]", r"robot in its robot.toml must be a table \[robot\]"),
        (
            "friction_coulomb",
            "friction_colomb",
            "an unknown key joints.friction_colomb; did you mean 'friction_coulomb'?",
        ),
        (
            "friction_coulomb = [1.0, ",
            "friction_coulomb = [",
            "friction_coulomb must be 7 numbers, one for each of panda_",
        ),
        (
            '"panda_joint1", "panda_joint2"',
            '"panda_joint2", "panda_joint1"',
            "must name the joints, .* in the order of the",
        ),
        ('"panda_joint1"', '"joint1"', "no joint 'joint1' to keep; the joints are panda_joint1"),
        ("locked = { panda_finger_joint1 = 0.02 }", "locked = 3", "joints.locked in its robot.toml must be a table"),
        (
            'names = ["panda_joint1"',
            'names = [1, "panda_joint1"',
            "joints.names in its robot.toml must be a list of names",
        ),
    ],
)
def test_a_folder_that_does_not_describe_an_arm_is_refused_in_a_sentence(folder, old, new, words):
    assert old in PANDA
    (folder / "robot.toml").write_text(PANDA.replace(old, new))
    with pytest.raises(ModelError, match=words):
        ArmModel.load(folder)


def test_a_folder_without_a_description_is_refused_with_the_names_of_the_shipped_arms(tmp_path):
    with pytest.raises(
        ModelError, match=r"it is neither a robot of the library \(.*wam7.*\) nor a folder that holds a rob"
    ):
        ArmModel.load(tmp_path)


def test_links_that_are_no_part_of_the_arm_are_left_out(folder):
    bare = PANDA.replace("[joints]", 'without = ["panda_hand"]\n\n[joints]').replace("locked", "# locked")
    heavy = ArmModel.load(folder).pinocchio_model.inertias[7].mass
    (folder / "robot.toml").write_text(bare)
    assert heavy - ArmModel.load(folder).pinocchio_model.inertias[7].mass == pytest.approx(0.76, abs=0.05)
    (folder / "robot.toml").write_text(bare.replace("panda_hand", "hand"))
    with pytest.raises(ModelError, match="no link 'hand' to leave out; the links are panda_link0"):
        ArmModel.load(folder)


def test_the_shipped_panda_is_that_of_example_robot_data_without_its_gripper():
    arm = ArmModel.load("panda")
    assert repr(arm) == "ArmModel('panda', nv=7, tool_frame='panda_link8')"
    assert arm.torque_limit.tolist() == [87.0] * 4 + [12.0] * 3
    assert arm.pinocchio_model.inertias[7].mass == pytest.approx(0.735522)


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("panda.urdf", '<mesh filename="../../etc/passwd"/>', "leads out of the folder my_panda"),
        ("panda.urdf", '<mesh filename="/etc/passwd"/>', "leads out of the folder"),
        ("panda.urdf", '<mesh filename="file:///etc/passwd"/>', "leads out of the folder"),
        ("panda.urdf", '<mesh filename="package://../secret.stl"/>', "leads out of the folder"),
        ("arm.xml", '<include file="/etc/passwd"/>', "leads out of the folder"),
        ("arm.xml", '<include file="arm.xml"/>', "includes itself"),
        ("arm.xml", '<compiler meshdir="/etc"/>', "leads out of the folder"),
        ("arm.xml", '<compiler meshdir="sub"/><asset><mesh file="../../x.stl"/></asset>', "leads out of the folder"),
        ("arm.xml", '<asset><texture fileright="/etc/x.png"/></asset>', "leads out of the folder"),
        ("arm.xml", '<include file="link.xml"/>', "leads out of the folder"),
    ],
)
def test_a_model_that_leads_out_of_its_folder_is_refused_in_a_sentence(folder, name, text, words):
    root = "robot" if name.endswith("urdf") else "mujoco"
    (folder.parent / "outside.xml").write_text("<mujoco/>")
    (folder / "link.xml").symlink_to(folder.parent / "outside.xml")
    (folder / name).write_text(f"<{root}>{text}</{root}>")
    key = "urdf" if root == "robot" else "mjcf"
    (folder / "robot.toml").write_text(PANDA.replace('urdf = "panda.urdf"', f'{key} = "{name}"'))
    with pytest.raises(ModelError, match=words) as refusal:
        ArmModel.load(folder)
    assert "\n" not in str(refusal.value)


def test_a_model_file_outside_the_folder_is_refused(folder):
    (folder.parent / "panda.urdf").write_bytes(panda_urdf().read_bytes())
    (folder / "robot.toml").write_text(PANDA.replace('urdf = "panda.urdf"', 'urdf = "../panda.urdf"'))
    with pytest.raises(ModelError, match="leads out of the folder; copy the file into it"):
        ArmModel.load(folder)


def test_a_description_that_is_a_link_out_of_its_folder_is_refused(folder):
    (folder / "robot.toml").rename(folder.parent / "other.toml")
    (folder / "robot.toml").symlink_to(folder.parent / "other.toml")
    with pytest.raises(ModelError, match="a link that leads out of the folder"):
        ArmModel.load(folder)


def test_a_model_in_a_package_that_is_not_installed_is_refused(folder):
    (folder / "robot.toml").write_text(PANDA.replace("[robot]", '[robot]\npackage = "no-such-robots"'))
    with pytest.raises(ModelError, match="the package no-such-robots, which is not installed; pip install"):
        ArmModel.load(folder)
