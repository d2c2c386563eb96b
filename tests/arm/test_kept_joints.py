"""Joints are kept by name or by number, the others locked, and each kind of joint stays what it is."""

import re

import numpy as np
import pinocchio as pin
import pytest

from pilegrasp_ctrl import ArmModel
from pilegrasp_ctrl.exceptions import ModelError, PilegraspError
from pilegrasp_ctrl.robots import PANDA_FINGERS, panda_urdf
from pilegrasp_ctrl.types import Pose

INERTIAL = '<inertial><mass value="1"/><inertia ixx="0.1" iyy="0.2" izz="0.3" ixy="0" ixz="0" iyz="0"/></inertial>'
AXES = ("0 0 1", "0 1 0", "0.6 0 0.8", "-1 0 0")
KINDS = ("revolute", "continuous", "prismatic")


def load(**arguments):
    return ArmModel.from_urdf(panda_urdf(), **{"tool_frame": "panda_hand_tcp", **arguments})


def same_states(arm, other, q=None, other_q=None):
    q = np.linspace(-0.5, 0.5, arm.nv) if q is None else np.asarray(q)
    v = np.linspace(1.0, -1.0, arm.nv)
    for own, others in zip(
        arm.update(q, v)[3:10], other.update(q if other_q is None else other_q, v)[3:10], strict=True
    ):
        np.testing.assert_allclose(own, others, atol=1e-9)


def test_a_number_keeps_the_first_joints_between_base_and_tool_frame():
    arm = load(joints=7)
    assert arm.joint_names == tuple(f"panda_joint{i}" for i in range(1, 8))
    same_states(arm, load(locked_joints=PANDA_FINGERS))
    assert load(joints=3).joint_names == ("panda_joint1", "panda_joint2", "panda_joint3")
    assert load(joints=8, tool_frame="panda_leftfinger").joint_names[-1] == "panda_finger_joint1"


def test_a_number_counts_joints_that_are_not_locked():
    arm = load(joints=6, locked_joints={"panda_joint3": 0.4, "panda_finger_joint1": 0.02})
    assert arm.joint_names == tuple(f"panda_joint{i}" for i in (1, 2, 4, 5, 6, 7))
    q = np.array([0.1, -0.3, 0.4, -2.0, 0.1, 1.7, 0.3])
    full = load(joints=7).update(q, np.zeros(7))
    np.testing.assert_allclose(arm.update(np.delete(q, 2), np.zeros(6)).translation, full.translation, atol=1e-12)


def test_names_keep_these_joints_in_the_order_of_the_model():
    arm = load(joints=["panda_joint4", "panda_joint2"])
    assert arm.joint_names == ("panda_joint2", "panda_joint4")
    np.testing.assert_array_equal(arm.torque_limit, load(joints=7).torque_limit[[1, 3]])


def test_numbers_of_the_joints_are_those_of_the_joints_that_are_kept():
    arm = load(joints=2, torque_limit=[50.0, 60.0], velocity_limit=[1.0, 2.0], armature=[0.1, 0.2])
    assert arm.torque_limit.tolist() == [50.0, 60.0]
    assert arm.pinocchio_model.armature.tolist() == [0.1, 0.2]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (
            {"joints": 8},
            "joints = 8 must be a number from 1 to 7, the movable joints between base and tool frame: panda_",
        ),
        ({"joints": 0}, "joints = 0 must be a number from 1 to 7"),
        ({"joints": True}, "joints = True must be a list of joint names, or a number of joints"),
        ({"joints": 7.0}, "joints = 7.0 must be a list of joint names, or a number of joints"),
        ({"joints": "panda_joint1"}, "joints = 'panda_joint1' must be a list of names, such as ['panda_joint1']"),
        ({"joints": ["elbow"]}, "no joint 'elbow' to keep; the joints are panda_joint1, panda_joint2"),
        ({"joints": [1, 2]}, "joints holds 1; it must hold names of joints"),
        ({"joints": []}, "no joint is left to control; lock fewer joints"),
        ({"joints": 7, "tool_frame": "panda_link0"}, "no movable joint lies between base and tool frame"),
        (
            {"joints": ["panda_joint1"], "locked_joints": ["panda_joint1"]},
            "joint 'panda_joint1' stands in joints and in locked_joints; take it out of one",
        ),
        ({"joints": 8, "tool_frame": "panda_rightfinger"}, "joints = 8 must be a number from 1 to 7"),
        (
            {"joints": ["panda_joint1", "panda_finger_joint1"], "tool_frame": "panda_rightfinger"},
            "joint 'panda_finger_joint2', between base and tool frame, follows 'panda_finger_joint1' (mimic)",
        ),
        ({"locked_joints": 5}, "locked_joints = 5 must be a list of names of joints"),
        ({"locked_joints": [None]}, "locked_joints holds None; it must hold names of joints"),
        ({"locked_joints": {"panda_joint1": "up"}}, "locked_joints holds 'up' as the position of 'panda_joint1'"),
        ({"locked_joints": {"panda_joint1": np.nan}}, "locked_joints holds nan as the position of 'panda_joint1'"),
        ({"locked_joints": PANDA_FINGERS, "tool_frame": "panda_link0"}, "no joint moves the tool frame 'panda_link0'"),
        ({"joints": 7, "gravity": "down"}, "gravity is 'down'; an array of numbers of the shape (3,) is expected"),
        ({"joints": 7, "gravity": [0.0, 0.0, np.nan]}, "gravity holds a value that is not finite"),
        ({"joints": 7, "base": np.eye(4)}, "base must be a Pose; it is a ndarray"),
        ({"joints": 7, "tool": 0.5}, "tool must be a MassProperties; it is a float"),
        ({"joints": 7, "transform_tool_to_frame": [0, 0, 1]}, "transform_tool_to_frame must be a Pose; it is a list"),
        (
            {"joints": 7, "torque_limits": np.ones(7)},
            "an arm has no argument 'torque_limits'; did you mean 'torque_limit'?",
        ),
        (
            {"joints": 7, "joint_to_motor": "x", "motor_torque_limit": np.ones(7)},
            "joint_to_motor must be an invertible",
        ),
    ],
)
def test_an_argument_that_does_not_fit_is_refused_in_a_sentence(arguments, words):
    with pytest.raises(PilegraspError, match=re.escape(words)) as refused:
        load(**arguments)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("source", [None, 7, "", "/", "/dev/zero"])
def test_what_is_no_model_file_is_refused_in_a_sentence(source):
    for read in (ArmModel.from_urdf, ArmModel.from_mjcf, ArmModel.load):
        with pytest.raises(ModelError, match=r"is not the path of|no such|is a folder|no arm"):
            read(source, **({} if read == ArmModel.load else {"tool_frame": "tool"}))


def chain(*joints):
    """The URDF of links in a row, each joint given as its type and axis."""
    parts = ['<link name="link0"/>']
    for number, (kind, axis) in enumerate(joints, start=1):
        parts.append(
            f'<link name="link{number}">{INERTIAL}</link><joint name="joint{number}" type="{kind}">'
            f'<parent link="link{number - 1}"/><child link="link{number}"/><axis xyz="{axis}"/>'
            '<origin xyz="0.1 0.2 0.3" rpy="0.1 0.2 0.3"/>'
            '<limit lower="-3" upper="3" effort="500" velocity="2"/></joint>'
        )
    return f'<robot name="chain">{"".join(parts)}</robot>'


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("axis", AXES)
def test_a_joint_of_any_kind_moves_along_or_about_its_axis_and_locks_where_it_is_told(tmp_path, kind, axis):
    file = tmp_path / "chain.urdf"
    file.write_text(chain(("revolute", "0 1 0"), (kind, axis), ("revolute", "1 0 0")))
    arm = ArmModel.from_urdf(file, "link3")
    assert arm.nv == 3
    usual = kind if kind == "prismatic" else "revolute"
    (tmp_path / "usual.urdf").write_text(chain(("revolute", "0 1 0"), (usual, axis), ("revolute", "1 0 0")))
    same_states(arm, ArmModel.from_urdf(tmp_path / "usual.urdf", "link3"))
    locked = ArmModel.from_urdf(file, "link3", locked_joints={"joint2": 0.8}).update([0.2, -0.3], np.zeros(2))
    free = arm.update([0.2, 0.8, -0.3], np.zeros(3))
    np.testing.assert_allclose(locked.translation, free.translation, atol=1e-12)
    np.testing.assert_allclose(locked.rotation, free.rotation, atol=1e-12)
    np.testing.assert_allclose(locked.M, free.M[np.ix_([0, 2], [0, 2])], atol=1e-9)


@pytest.mark.parametrize("axis", AXES)
def test_a_pinocchio_model_with_continuous_joints_is_converted_too(axis):
    continuous = pin.buildModelFromXML(chain(("continuous", axis), ("continuous", "0 1 0")))
    assert continuous.nq == 4
    arm = ArmModel(continuous, "link2")
    assert arm.nv == 2
    assert np.isinf([arm.q_lower, arm.q_upper]).all()
    same_states(arm, ArmModel(pin.buildModelFromXML(chain(("revolute", axis), ("revolute", "0 1 0"))), "link2"))
    limited = ArmModel(continuous, "link2", q_lower=[-1.0, -2.0], q_upper=[1.0, 2.0])
    assert limited.q_upper.tolist() == [1.0, 2.0]


@pytest.mark.parametrize(
    ("joint", "words"),
    [
        (pin.JointModelFreeFlyer(), "joint 'odd' is a floating base, neither revolute nor prismatic; lock it"),
        (pin.JointModelSpherical(), "joint 'odd' is of the kind Spherical, neither revolute nor prismatic"),
        (pin.JointModelSphericalZYX(), "joint 'odd' is of the kind SphericalZYX"),
        (pin.JointModelPlanar(), "joint 'odd' is of the kind Planar"),
        (pin.JointModelTranslation(), "joint 'odd' is of the kind Translation"),
    ],
)
def test_a_joint_of_several_coordinates_is_refused_by_name(joint, words):
    model = pin.Model()
    model.addJoint(0, joint, pin.SE3.Identity(), "odd")
    with pytest.raises(ModelError, match=words):
        ArmModel(model, "tool")


def test_a_mimic_joint_of_a_pinocchio_model_is_refused_by_name():
    model = pin.buildModelFromUrdf(str(panda_urdf()), True)
    with pytest.raises(ModelError, match="'panda_finger_joint2' follows another joint"):
        ArmModel(model, "panda_hand_tcp")


def test_a_frame_of_the_users_own_name_is_not_mistaken_for_the_controlled_one(tmp_path):
    file = tmp_path / "chain.urdf"
    file.write_text(chain(("revolute", "0 1 0"), ("revolute", "0 1 0")).replace("link1", "link2_tool"))
    arm = ArmModel.from_urdf(file, "link2", transform_tool_to_frame=Pose([0.0, 0.0, 1.0]))
    bare = ArmModel.from_urdf(file, "link2").update([0.1, 0.2], [0.0, 0.0])
    expected = bare.pose @ Pose([0.0, 0.0, 1.0])
    for made in (arm, arm.replace(gravity=(0.0, 0.0, -1.0)), arm.with_payload(1.0, [0.0, 0.0, 0.0])):
        state = made.update([0.1, 0.2], [0.0, 0.0])
        np.testing.assert_allclose(state.translation, expected.translation, atol=1e-12)
        np.testing.assert_allclose(state.frame(made.tool_frame).translation, expected.translation, atol=1e-12)
