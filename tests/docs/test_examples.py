"""The scripts in docs/examples: they run, and do what their pages say."""

import re
import runpy

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from pilegrasp_ctrl.robots import panda_urdf
from places import ROOT

EXAMPLES = ROOT / "docs" / "examples"


SCRIPTS = sorted(EXAMPLES.glob("*.py"))
NUMBER = r"-?\d+(?:\.\d+)?"


def numbers(script: str, capsys) -> list[float]:
    """The numbers that an example prints."""
    runpy.run_path(str(EXAMPLES / script), run_name="__main__")
    return [float(number) for number in re.findall(NUMBER, capsys.readouterr().out)]


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.name)
def test_an_example_is_short_and_is_in_the_table(path):
    assert len(path.read_text(encoding="utf-8").splitlines()) < 40
    assert f"[{path.name}]({path.name})" in (EXAMPLES / "README.md").read_text(encoding="utf-8")


def test_the_panda_of_ones_own_scene_stays_on_its_line(capsys):
    (distance,) = numbers("own_mujoco_loop.py", capsys)
    assert distance < 0.2


def test_a_first_line_is_followed(capsys):
    (distance,) = numbers("first_line.py", capsys)
    assert distance < 0.1


def test_a_task_of_one_s_own_is_followed_beside_the_tool(capsys):
    distance, wanted, error = numbers("own_task.py", capsys)
    assert distance == pytest.approx(wanted, abs=0.5)
    assert error < 0.1


def test_a_limit_of_one_s_own_stops_the_tool_and_is_named(capsys):
    runpy.run_path(str(EXAMPLES / "own_limit.py"))
    out = capsys.readouterr().out
    assert -0.01 < float(re.search(NUMBER, out)[0]) < 0.1
    assert "wall upper" in out


def test_two_frames_move_at_once(capsys):
    error, side = numbers("two_frames.py", capsys)
    assert error < 0.1
    assert side == pytest.approx(80.0, abs=0.5)


def test_the_joints_go_home_at_the_speed_that_is_asked_for(capsys):
    distance, speed = numbers("going_home.py", capsys)
    assert distance < 1e-3
    assert 0.45 < speed < 0.51


def test_an_arm_that_is_led_by_hand_stays_where_it_is_left(capsys):
    away, _, drift = numbers("teaching_by_hand.py", capsys)
    assert away < 2.0
    assert drift < 2.0


def test_a_payload_that_is_told_is_carried_without_sag(capsys):
    before, after = numbers("payload.py", capsys)
    assert before > 3.0
    assert after < 0.01


def test_the_scene_holds_the_panda_of_the_urdf():
    scene = mujoco.MjModel.from_xml_path(str(EXAMPLES / "panda_scene.xml"))
    data, urdf = mujoco.MjData(scene), pin.buildModelFromUrdf(str(panda_urdf()))
    other, hand = urdf.createData(), urdf.getFrameId("panda_hand_tcp")
    joints = [scene.joint(name) for name in list(urdf.names)[1:]]
    dofs = [int(joint.dofadr[0]) for joint in joints]
    random = np.random.default_rng(0)
    for _ in range(5):
        q = random.uniform(urdf.lowerPositionLimit, urdf.upperPositionLimit)
        data.qpos[[int(joint.qposadr[0]) for joint in joints]] = q
        mujoco.mj_forward(scene, data)
        mass = np.zeros((scene.nv, scene.nv))
        mujoco.mj_fullM(scene, data, mass)
        np.testing.assert_allclose(mass[np.ix_(dofs, dofs)], pin.crba(urdf, other, q), atol=1e-5)
        pin.framesForwardKinematics(urdf, other, q)
        base, site = data.body("panda_link0"), data.site("panda_hand_tcp")
        point = base.xmat.reshape(3, 3).T @ (site.xpos - base.xpos)
        np.testing.assert_allclose(point, other.oMf[hand].translation, atol=1e-5)
    limits = np.stack([urdf.lowerPositionLimit, urdf.upperPositionLimit], axis=1)
    np.testing.assert_allclose([joint.range for joint in joints], limits, atol=1e-4)
    torques = [scene.actuator(f"motor{number}").ctrlrange[1] for number in range(1, 8)]
    np.testing.assert_array_equal(torques, urdf.effortLimit[:7])
