"""URDFs of many kinds: continuous and mimic joints, missing inertials, shared names, and arguments that do not fit."""

import re

import numpy as np
import pinocchio as pin
import pytest

from arms import HOME
from pilegrasp_ctrl import ArmModel, ArmSimulation, OperationalSpaceController, StraightLine
from pilegrasp_ctrl.exceptions import ModelError, PilegraspError
from pilegrasp_ctrl.plant.tracking import simulate_tracking
from pilegrasp_ctrl.robots import PANDA_FINGERS, panda_urdf

INERTIAL = '<inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>'


def changed(tmp_path, *changes):
    """The Panda's URDF with some texts replaced, as a file."""
    text = panda_urdf().read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    (tmp_path / "changed.urdf").write_text(text)
    return tmp_path / "changed.urdf"


def continuous(*joints):
    """Changes that make joints of the Panda continuous."""
    return [(f'name="{joint}" type="revolute"', f'name="{joint}" type="continuous"') for joint in joints]


def load(file, **arguments):
    return ArmModel.from_urdf(file, **{"tool_frame": "panda_hand_tcp", "locked_joints": PANDA_FINGERS, **arguments})


def chain(tmp_path, *masses, joint="revolute", axis="0 1 0"):
    """A URDF of links in a row; a link without a mass has no inertial."""
    links = ['<link name="base"/>']
    for number, mass in enumerate(masses):
        parent = "base" if number == 0 else f"link{number - 1}"
        links.append(f'<link name="link{number}">{INERTIAL if mass else ""}</link>')
        links.append(
            f'<joint name="joint{number}" type="{joint}"><parent link="{parent}"/><child link="link{number}"/>'
            f'<origin xyz="0 0 0.3"/><axis xyz="{axis}"/><limit lower="-3" upper="3" effort="50" velocity="2"/></joint>'
        )
    (tmp_path / "chain.urdf").write_text(f'<robot name="chain">{"".join(links)}</robot>')
    return tmp_path / "chain.urdf"


def test_a_continuous_joint_is_a_revolute_one_without_limits(tmp_path):
    usual = load(panda_urdf())
    endless = load(changed(tmp_path, *continuous("panda_joint1", "panda_joint7")))
    assert endless.nv == 7
    assert endless.joint_names == usual.joint_names
    assert np.isinf(endless.q_upper).tolist() == [True, False, False, False, False, False, True]
    np.testing.assert_array_equal(endless.q_lower[1:6], usual.q_lower[1:6])
    np.testing.assert_array_equal(endless.torque_limit, usual.torque_limit)
    rng = np.random.default_rng(0)
    for _ in range(5):
        q, v = rng.uniform(-2.0, 2.0, (2, 7))
        for own, others in zip(endless.update(q, v)[:10], usual.update(q, v)[:10], strict=True):
            np.testing.assert_allclose(own, others, atol=1e-9)


@pytest.mark.parametrize("axis", ["1 0 0", "0 -1 0", "0 0 1", "0.6 0 0.8"])
def test_a_continuous_joint_turns_about_its_axis(tmp_path, axis):
    arm = ArmModel.from_urdf(chain(tmp_path, 1, 1, joint="continuous", axis=axis), "link1")
    direction = np.array(axis.split(), dtype=float)
    rotation = arm.update([0.4, 0.3], [0.0, 0.0]).rotation
    np.testing.assert_allclose(pin.log3(rotation), 0.7 * direction, atol=1e-12)


def test_an_arm_with_continuous_joints_tracks_like_the_others(tmp_path):
    arm = load(changed(tmp_path, *continuous("panda_joint1", "panda_joint3", "panda_joint5", "panda_joint7")))
    q = HOME["panda"]
    line = StraightLine(arm.update(q, np.zeros(7)).pose, [0.0, 0.2, 0.0], 0.1)
    motion = simulate_tracking(
        ArmSimulation(arm), OperationalSpaceController(arm, posture=q), line.at, q, line.duration
    )
    assert np.abs(motion.error[:, :3]).max() < 2e-4
    assert motion.active_limits() == ()


def test_a_continuous_joint_can_be_locked_at_an_angle(tmp_path):
    file, q = changed(tmp_path, *continuous("panda_joint7")), HOME["panda"]
    locked = load(file, locked_joints={**dict.fromkeys(PANDA_FINGERS, 0.0), "panda_joint7": q[6]})
    state = locked.update(q[:6], np.zeros(6))
    expected = load(panda_urdf()).update(q, np.zeros(7))
    np.testing.assert_allclose(state.rotation, expected.rotation, atol=1e-12)
    np.testing.assert_allclose(state.translation, expected.translation, atol=1e-12)


def test_a_joint_that_moves_no_mass_is_named(tmp_path):
    with pytest.raises(ModelError, match=r"chain: the links that joint 'joint1' moves have no mass"):
        ArmModel.from_urdf(chain(tmp_path, 1, 0), "link1")
    assert ArmModel.from_urdf(chain(tmp_path, 0, 1), "link1").nv == 2


def test_a_mimic_joint_is_no_motor():
    with pytest.raises(ModelError, match=r"'panda_finger_joint2' follows 'panda_finger_joint1' \(mimic\)"):
        load(panda_urdf(), locked_joints=["panda_finger_joint1"])


def test_an_arm_needs_a_joint_and_one_is_enough(tmp_path):
    with pytest.raises(ModelError, match="no joint is left"):
        ArmModel.from_urdf(chain(tmp_path, 1), "link0", locked_joints=["joint0"])
    arm = ArmModel.from_urdf(chain(tmp_path, 1), "link0")
    controller = OperationalSpaceController(arm, mask=[True, *5 * [False]])
    reference = StraightLine(arm.update([0.5], [0.0]).pose, [0.0, 0.0, 0.0], 0.1).at(0.0)
    observation = next(ArmSimulation(arm).run(lambda seen: controller.step(seen, reference).command.torque, [0.5], 0.1))
    assert np.isfinite(observation.torque).all()


def test_a_link_and_a_joint_may_share_a_name(tmp_path):
    file = chain(tmp_path, 1, 1)
    file.write_text(file.read_text().replace("joint1", "tool").replace("link1", "tool"))
    assert ArmModel.from_urdf(file, "tool").update([0.0, 0.0], [0.0, 0.0]).translation[2] == pytest.approx(0.6)


def test_a_joint_named_twice_is_locked_once():
    assert load(panda_urdf(), locked_joints=[*PANDA_FINGERS, PANDA_FINGERS[0]]).nv == 7


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"locked_joints": "panda_finger_joint1"}, "locked_joints = 'panda_finger_joint1' must be a list of names"),
        ({"tool_frame": None}, "no frame None for the tool; the links are panda_link0"),
        ({"gravity": 9.81}, "gravity has shape (); (3,) is expected"),
        ({"torque_limit": {"panda_joint1": 80.0}}, "torque_limit must be 7 numbers, one for each of panda_joint1"),
        ({"velocity_limit": ["fast"] * 7}, "velocity_limit must be 7 numbers"),
    ],
)
def test_an_argument_that_does_not_fit_is_refused_in_a_sentence(arguments, words):
    with pytest.raises(PilegraspError, match=re.escape(words)) as refused:
        load(panda_urdf(), **arguments)
    assert "\n" not in str(refused.value)
