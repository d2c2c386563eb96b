"""An arm's kinematics and dynamics are consistent, and its limits, friction and errors are those of its files."""

import numpy as np
import pinocchio as pin
import pytest

from arms import ARMS, HOME, load, random_states
from pilegrasp_ctrl.arm.model import ArmModel
from pilegrasp_ctrl.exceptions import ModelError
from pilegrasp_ctrl.robots import panda_urdf
from pilegrasp_ctrl.types import MassProperties, Pose

BASE = Pose([0.3, -0.2, 0.5], pin.rpy.rpyToMatrix(0.1, -0.2, 0.3))
TOOL = MassProperties(0.8, [0.02, -0.01, 0.09], np.diag([3e-3, 2e-3, 1e-3]))
TOOL_FRAME = Pose([0.05, 0.01, 0.15], pin.rpy.rpyToMatrix(0.2, 0.4, -0.3))


@pytest.fixture(params=ARMS)
def arm(request):
    return load(request.param, base=BASE, tool=TOOL, transform_tool_to_frame=TOOL_FRAME)


def test_the_twist_is_the_derivative_of_the_pose(arm):
    step = 1e-6
    for q, v in random_states(arm, 5):
        before, after = arm.update(q - step * v, v), arm.update(q + step * v, v)
        state = arm.update(q, v)
        linear = (after.translation - before.translation) / (2 * step)
        angular = pin.log3(after.rotation @ before.rotation.T) / (2 * step)
        np.testing.assert_allclose(state.twist, np.concatenate((linear, angular)), atol=1e-8)
        np.testing.assert_allclose(state.J @ v, state.twist, atol=1e-12)


def test_jdot_v_is_the_tool_acceleration_at_zero_joint_acceleration(arm):
    step = 1e-6
    for q, v in random_states(arm, 5):
        after, before = arm.update(q + step * v, v), arm.update(q - step * v, v)
        np.testing.assert_allclose(arm.update(q, v).Jdot_v, (after.twist - before.twist) / (2 * step), atol=1e-7)


def test_inertia_and_bias_reproduce_the_forward_dynamics(arm):
    model = arm.pinocchio_model
    data = model.createData()
    torque = np.linspace(-5.0, 5.0, arm.nv)
    for q, v in random_states(arm, 5):
        state = arm.update(q, v)
        np.testing.assert_allclose(state.M, state.M.T, atol=1e-14)
        np.testing.assert_allclose(
            np.linalg.solve(state.M, torque - state.h), pin.aba(model, data, q, v, torque), atol=1e-8
        )


def test_gravity_is_the_slope_of_the_potential_energy_of_all_masses_including_the_tool(arm):
    model = arm.pinocchio_model
    data = model.createData()
    q, step = next(random_states(arm, 1))[0], 1e-6
    slope = [
        (pin.computePotentialEnergy(model, data, q + step * e) - pin.computePotentialEnergy(model, data, q - step * e))
        / (2 * step)
        for e in np.eye(arm.nv)
    ]
    np.testing.assert_allclose(arm.update(q, np.zeros(arm.nv)).h, slope, atol=1e-6)


@pytest.mark.parametrize("name", ARMS)
def test_the_tool_adds_its_weight_at_its_centre_of_mass(name):
    q, v = HOME[name], np.zeros(7)
    centre = Pose(TOOL.center_of_mass)
    bare, loaded = load(name, transform_tool_to_frame=centre), load(name, tool=TOOL, transform_tool_to_frame=centre)
    weight = np.array([0.0, 0.0, 9.81 * TOOL.mass])
    state = bare.update(q, v)
    np.testing.assert_allclose(loaded.update(q, v).h - state.h, state.J[:3].T @ weight, atol=1e-9)


@pytest.mark.parametrize("name", ARMS)
def test_base_and_tool_frame_compose_with_the_arm(name):
    q, v = HOME[name], np.zeros(7)
    expected = BASE @ load(name).update(q, v).pose @ TOOL_FRAME
    pose = load(name, base=BASE, transform_tool_to_frame=TOOL_FRAME).update(q, v).pose
    np.testing.assert_allclose(pose.translation, expected.translation, atol=1e-12)
    np.testing.assert_allclose(pose.rotation, expected.rotation, atol=1e-12)


def test_a_state_is_not_changed_by_the_next_update(arm):
    (q, v), (other, w) = random_states(arm, 2)
    state = arm.update(q, v)
    copies = [np.array(array) for array in state[:10]]
    q_copy = q.copy()
    arm.update(other, w)
    q += 1.0
    for array, copy in zip(state[:10], copies, strict=True):
        np.testing.assert_array_equal(array, copy)
    np.testing.assert_array_equal(state.q, q_copy)


def test_the_wam_is_loaded_with_the_numbers_of_its_description():
    arm = load("wam7")
    assert arm.joint_names == ("j1", "j2", "j3", "j4", "j5", "j6", "j7")
    np.testing.assert_array_equal(arm.torque_limit, [77.3, 160.6, 95.6, 29.4, 11.6, 11.6, 2.7])
    np.testing.assert_array_equal(arm.friction_coulomb, [2.7, 2.5, 1.5, 1.1, 0.4, 0.4, 0.1])
    np.testing.assert_array_equal(arm.pinocchio_model.armature[:4], [0.205, 0.189, 0.0669, 0.0346])


def test_an_arm_without_known_friction_has_none():
    assert not load("panda").friction_coulomb.any()


def test_limits_are_read_only_and_the_pinocchio_model_is_a_copy(arm):
    with pytest.raises(ValueError, match="read-only"):
        arm.torque_limit[0] = 1.0
    q = np.zeros(arm.nv)
    before = arm.update(q, q).h
    arm.pinocchio_model.gravity.linear = np.zeros(3)
    np.testing.assert_array_equal(arm.update(q, q).h, before)


@pytest.mark.parametrize(
    ("q", "v", "message"),
    [
        (np.zeros(6), np.zeros(7), r"shape \(7,\)"),
        (np.zeros(7), np.zeros((7, 1)), r"shape \(7,\)"),
        (np.full(7, np.nan), np.zeros(7), "not finite"),
        (np.zeros(7), np.array([0, 0, 0, 0, 0, 0, -np.inf]), "not finite"),
    ],
)
def test_a_state_of_wrong_shape_or_with_nan_is_rejected(q, v, message):
    with pytest.raises(ModelError, match=message):
        load("panda").update(q, v)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"tool_frame": "hook"}, "no frame 'hook'.*panda_hand_tcp"),
        ({"locked_joints": ["elbow"]}, "no joint 'elbow'.*panda_joint1"),
        ({"torque_limit": np.ones(3)}, "torque_limit must be 7"),
        ({"velocity_limit": np.zeros(7)}, "'panda_joint1' does not have velocity_limit > 0"),
        ({"q_lower": np.full(7, 9.0)}, "q_lower < q_upper"),
        ({"armature": -np.ones(7)}, "armature"),
        ({"friction_coulomb": np.full(7, np.inf)}, "friction_coulomb"),
    ],
)
def test_an_inconsistent_model_is_rejected(arguments, message):
    arguments = {
        "locked_joints": ["panda_finger_joint1", "panda_finger_joint2"],
        "tool_frame": "panda_hand_tcp",
        **arguments,
    }
    with pytest.raises(ModelError, match=message):
        ArmModel.from_urdf(panda_urdf(), **arguments)


def test_an_error_names_the_file_that_cannot_be_used(tmp_path):
    with pytest.raises(ModelError, match="no such URDF"):
        ArmModel.from_urdf(tmp_path / "arm.urdf", "flange")
    (tmp_path / "arm.urdf").write_text("<robot")
    with pytest.raises(ModelError, match=r"arm\.urdf"):
        ArmModel.from_urdf(tmp_path / "arm.urdf", "flange")
    with pytest.raises(ModelError, match="wam8"):
        ArmModel.load("wam8")
    with pytest.raises(ModelError, match="not an arm"):
        ArmModel.load("hands/shovel")


def test_a_joint_can_be_locked_at_a_given_position():
    names = {"panda_finger_joint1": 0.0, "panda_finger_joint2": 0.0}
    locked = ArmModel.from_urdf(panda_urdf(), "panda_hand_tcp", locked_joints={**names, "panda_joint7": 0.3})
    q = HOME["panda"]
    assert locked.nv == 6
    np.testing.assert_allclose(
        locked.update(q[:6], np.zeros(6)).rotation, load("panda").update(q, np.zeros(7)).rotation, atol=1e-12
    )


def test_an_arm_prints_its_name_its_joints_and_its_tool_frame():
    arm = load("panda")
    assert repr(arm) == f"ArmModel({arm.name!r}, nv=7, tool_frame='panda_hand_tcp')"
    assert repr(ArmModel.load("wam7")) == "ArmModel('wam7', nv=7, tool_frame='flange')"
