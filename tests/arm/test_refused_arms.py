"""What cannot be controlled is refused when the arm is made, in one sentence with the name of the joint."""

import re

import numpy as np
import pinocchio as pin
import pytest

from pilegrasp_ctrl import ArmModel
from pilegrasp_ctrl.exceptions import ModelError

LIMIT = '<limit lower="-3" upper="3" effort="100" velocity="2"/>'


def inertial(mass="1", xx="0.1", yy="0.1", zz="0.1", xy="0", at="0 0 0"):
    return (
        f'<inertial><origin xyz="{at}"/><mass value="{mass}"/>'
        f'<inertia ixx="{xx}" iyy="{yy}" izz="{zz}" ixy="{xy}" ixz="0" iyz="0"/></inertial>'
    )


def arm(
    tmp_path, bodies=None, limits=(LIMIT, LIMIT), kinds=("revolute", "revolute"), axes=("0 1 0", "0 1 0"), **options
):
    """Return an arm of two joints, with inertials, limits, kinds and axes as given."""
    bodies = (inertial(), inertial()) if bodies is None else bodies
    text = '<robot name="r"><link name="base"/>'
    parents = ("base", "link1")
    for number, (body, limit, kind, axis, parent) in enumerate(
        zip(bodies, limits, kinds, axes, parents, strict=True), 1
    ):
        text += (
            f'<link name="link{number}">{body}</link><joint name="joint{number}" type="{kind}">'
            f'<parent link="{parent}"/><child link="link{number}"/><origin xyz="0 0 0.3"/>'
            f'<axis xyz="{axis}"/>{limit}</joint>'
        )
    file = tmp_path / "r.urdf"
    file.write_text(text + "</robot>")
    return ArmModel.from_urdf(file, "link2", **options)


def test_a_usual_arm_is_not_refused(tmp_path):
    assert arm(tmp_path).nv == 2


@pytest.mark.parametrize(
    ("limit", "words"),
    [
        (
            '<limit lower="-3" upper="3" effort="0" velocity="2"/>',
            "'joint2' has a torque_limit of 0; give torque_limit",
        ),
        ('<limit lower="-3" upper="3" velocity="2"/>', "'joint2' has a torque_limit of 0; give torque_limit"),
        ('<limit lower="-3" upper="3" effort="inf" velocity="2"/>', "'joint2' has a torque_limit of inf"),
        ('<limit lower="-3" upper="3" effort="-5" velocity="2"/>', "'joint2' has a torque_limit of -5"),
        (
            '<limit lower="-3" upper="3" effort="nan" velocity="2"/>',
            "limit effort of joint 'joint2' is 'nan'; it must be",
        ),
        ('<limit lower="-3" upper="3" effort="5" velocity="0"/>', "'joint2' does not have velocity_limit > 0"),
        ('<limit lower="-3" upper="3" effort="5" velocity="fast"/>', "limit velocity of joint 'joint2' is 'fast'"),
        ('<limit lower="3" upper="-3" effort="5" velocity="2"/>', "'joint2' does not have q_lower < q_upper"),
        ('<limit effort="5" velocity="2"/>', "'joint2' does not have q_lower < q_upper"),
        ("", "'joint2' does not have q_lower < q_upper; give the limits"),
    ],
)
def test_a_limit_that_is_missing_or_impossible_is_named(tmp_path, limit, words):
    with pytest.raises(ModelError, match=re.escape(words)):
        arm(tmp_path, limits=(LIMIT, limit))


def test_missing_limits_can_be_given(tmp_path):
    given = {"q_lower": [-1, -1], "q_upper": [1, 1], "velocity_limit": [2, np.inf], "torque_limit": [90, 80]}
    made = arm(tmp_path, limits=(LIMIT, ""), **given)
    for name, value in given.items():
        np.testing.assert_array_equal(getattr(made, name), value)


def test_an_infinite_limit_of_speed_or_position_is_no_limit(tmp_path):
    made = arm(tmp_path, limits=(LIMIT, '<limit lower="-inf" upper="inf" effort="9" velocity="inf"/>'))
    assert made.velocity_limit.tolist() == [2.0, np.inf]
    assert (made.q_lower[1], made.q_upper[1]) == (-np.inf, np.inf)
    endless = arm(tmp_path, limits=(LIMIT, '<limit effort="9" velocity="2"/>'), kinds=("revolute", "continuous"))
    assert endless.q_upper[1] == np.inf


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ("", "the links that joint 'joint2' moves have no mass"),
        (inertial("0"), "the links that joint 'joint2' moves have no mass"),
        (inertial("-1"), "the mass of link 'link2' on joint 'joint2' is negative"),
        (inertial("nan"), "mass value of link 'link2' on joint 'joint2' is 'nan'; it must be a number"),
        (inertial("inf"), "mass value of link 'link2' on joint 'joint2' is 'inf'; it must be finite"),
        (inertial("heavy"), "mass value of link 'link2' on joint 'joint2' is 'heavy'"),
        (inertial(xx="nan"), "inertia ixx of link 'link2' on joint 'joint2' is 'nan'"),
        (inertial(xx="-0.1"), "the link on joint 'joint2' has a mass of 1 kg and principal moments of inertia -0.1"),
        (inertial(xy="0.5"), "the link on joint 'joint2' has a mass of 1 kg and principal moments of inertia -0.4"),
        (inertial(at="0 0 inf"), "origin xyz of link 'link2' on joint 'joint2' is '0 0 inf'"),
        (
            '<inertial><mass value="1"/></inertial>',
            "the inertial of link 'link2' on joint 'joint2' lacks its mass or the",
        ),
        (inertial(xx="0", yy="0", zz="0"), "what joint 'joint2' moves has no inertia against its motion"),
    ],
)
def test_a_body_that_cannot_be_is_named(tmp_path, body, words):
    with pytest.raises(ModelError, match=re.escape(words)) as refused:
        arm(tmp_path, bodies=(inertial(), body))
    assert "\n" not in str(refused.value)


def test_two_joints_about_one_axis_need_an_inertia_between_them(tmp_path):
    file = tmp_path / "r.urdf"
    arm(tmp_path, bodies=("", inertial()))
    file.write_text(file.read_text().replace('<origin xyz="0 0 0.3"/>', ""))
    with pytest.raises(ModelError, match=r"what joint 'joint[12]' moves has no inertia against its motion"):
        ArmModel.from_urdf(file, "link2")
    assert ArmModel.from_urdf(file, "link2", armature=[0.1, 0.1]).nv == 2


def test_a_motor_that_cannot_carry_its_links_in_any_posture_is_named(tmp_path):
    lift = {"kinds": ("prismatic", "revolute"), "axes": ("0 0 1", "0 1 0")}
    words = r"joint 'joint1' cannot carry its links: gravity takes 19\.6 N·m or more in every posture, and torque_limit"
    with pytest.raises(ModelError, match=words):
        arm(tmp_path, torque_limit=[19.0, 9.0], **lift)
    with pytest.raises(ModelError, match="joint 'joint1' cannot carry"):
        arm(tmp_path, torque_limit=[22.0, 9.0], friction_coulomb=[3.0, 0.0], **lift)
    assert arm(tmp_path, torque_limit=[20.0, 9.0], **lift).nv == 2
    with pytest.raises(ModelError, match="joint 'joint2' cannot carry its links: gravity takes 0 N·m"):
        arm(tmp_path, torque_limit=[20.0, 2.0], friction_coulomb=[0.0, 2.0], **lift)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('type="revolute"><parent link="link1"', 'type="hinge"><parent link="link1"', "'joint2' has the type 'hinge'"),
        ('type="revolute"><parent link="link1"', 'type="floating"><parent link="link1"', "'joint2' is a floating base"),
        (
            'type="revolute"><parent link="link1"',
            'type="planar"><parent link="link1"',
            "'joint2' is of the kind Planar",
        ),
        ('parent link="link1"', 'parent link="nothing"', "the parent link 'nothing' of joint 'joint2' does not exist"),
        ('parent link="link1"', 'parent link="link2"', "joint 'joint2' hangs on itself, a closed loop"),
        ('name="joint2"', 'name="joint1"', "two joints have the name 'joint1'; rename one"),
        (
            'child link="link2"',
            'child link="link1"',
            "joints 'joint1' and 'joint2' both carry link 'link1', a closed loop",
        ),
        ('axis xyz="0 1 0"', 'axis xyz="0 0 0"', "the axis of joint 'joint1' is zero; give its direction"),
        ('axis xyz="0 1 0"', 'axis xyz="0 1"', "the axis xyz of joint 'joint1' is '0 1'; it must be finite numbers"),
        ("</robot>", '<link name="spare"/></robot>', "no joint carries the links base, spare; a URDF is a tree"),
    ],
)
def test_a_urdf_that_is_no_tree_of_joints_is_refused_with_the_name_at_fault(tmp_path, old, new, words):
    arm(tmp_path)
    file = tmp_path / "r.urdf"
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new))
    with pytest.raises(ModelError, match=re.escape(words)):
        ArmModel.from_urdf(file, "link2")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<sdf/>", "has the root <sdf>; a URDF has the root <robot>, an MJCF <mujoco>"),
        ('<robot xmlns:x="http://ros.org/wiki/xacro"><x:if value="1"/></robot>', "holds xacro macros; expand it first"),
        ("<robot/>", "a joint carries each of 0 links; a URDF is a tree"),
        ("<robot", "not a URDF or MJCF file, because it is not XML"),
        ("", "not a URDF or MJCF file, because it is not XML"),
        ("<mujoco><arm/></mujoco>", "not a model that MuJoCo can compile"),
    ],
)
def test_a_file_of_another_kind_is_refused_in_a_sentence(tmp_path, text, words):
    file = tmp_path / "r.urdf"
    file.write_text(text)
    with pytest.raises(ModelError, match=re.escape(words)) as refused:
        ArmModel.from_urdf(file, "link2")
    assert "\n" not in str(refused.value)


def test_a_pinocchio_model_is_examined_like_a_file():
    def model(limit, mass, inertia):
        made = pin.Model()
        made.addJoint(0, pin.JointModelRY(), pin.SE3.Identity(), "hinge")
        made.effortLimit, made.velocityLimit = np.array([limit]), np.array([2.0])
        made.lowerPositionLimit, made.upperPositionLimit = np.array([-3.0]), np.array([3.0])
        body = pin.Inertia(mass, np.zeros(3), np.zeros((3, 3)))
        body.inertia = inertia
        made.appendBodyToJoint(1, body, pin.SE3.Identity())
        made.addBodyFrame("link", 1, pin.SE3.Identity(), 0)
        return made

    assert ArmModel(model(5.0, 1.0, np.eye(3)), "link").nv == 1
    for limit, mass, inertia, words in (
        (np.inf, 1.0, np.eye(3), "'hinge' has a torque_limit of inf"),
        (0.0, 1.0, np.eye(3), "'hinge' has a torque_limit of 0"),
        (np.nan, 1.0, np.eye(3), "torque_limit of joint 'hinge' is not a number"),
        (5.0, 0.0, np.zeros((3, 3)), "'hinge' moves have no mass"),
        (5.0, -1.0, np.eye(3), "the link on joint 'hinge' has a mass of -1 kg"),
        (5.0, np.nan, np.eye(3), "the link on joint 'hinge' has a mass or inertia that is not finite"),
        (5.0, 1.0, -np.eye(3), "the link on joint 'hinge' has a mass of 1 kg and principal moments of inertia -1"),
    ):
        with pytest.raises(ModelError, match=words):
            ArmModel(model(limit, mass, inertia), "link")
    with pytest.raises(ModelError, match="model must be a Model; it is a str"):
        ArmModel("panda.urdf", "link")
    with pytest.raises(ModelError, match="no joint is left to control"):
        ArmModel(pin.Model(), "universe")
