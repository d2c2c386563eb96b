"""The simulated arm is the arm of the folder: inertia, friction, torque limits and ranges are what the folder says."""

import mujoco
import numpy as np
import pytest

from pilegrasp_ctrl.arm.model import ArmModel
from pilegrasp_ctrl.exceptions import ModelError
from pilegrasp_ctrl.planning.simulated_arm import ArmBodies, simulated_arm
from pilegrasp_ctrl.robots import path
from pilegrasp_ctrl.sim.arm_body import file_of, mount_arm
from pilegrasp_ctrl.sim.scene import new_spec

SLIDER = """
<mujoco><worldbody><body name="base"><geom size="0.1"/>
<body name="rail" pos="0.1 0 0.2"><joint name="x" type="slide" axis="1 0 0" range="-1 1" armature="0.3" damping="2"
 frictionloss="1.5"/><geom type="capsule" size="0.04 0.1" mass="3"/>
<body name="link1" pos="0 0 0.1"><joint name="a" axis="0 1 0" ref="0.3" range="-2 2"/>
 <geom type="capsule" fromto="0 0 0 0 0 0.4" size="0.04" mass="2"/>
<body name="link2" pos="0 0 0.4"><joint name="b" axis="1 1 0"/>
 <geom type="capsule" fromto="0 0 0 0.1 0 0.3" size="0.03" mass="1"/><site name="tip" pos="0.1 0 0.3"/></body>
</body></body></body></worldbody>
<actuator><motor joint="x" ctrlrange="-90 90"/><motor joint="a" ctrlrange="-40 40" gear="2"/>
<position joint="b" kp="100" forcerange="-12 12"/></actuator></mujoco>
"""


@pytest.fixture
def slider(tmp_path):
    """Return the folder of an arm with a slide, a joint with a reference, and a servo in place of a motor."""
    (tmp_path / "slider.xml").write_text(SLIDER)
    (tmp_path / "robot.toml").write_text(
        '[robot]\nmjcf = "slider.xml"\nflange_frame = "tip"\n[joints]\nnames = ["x", "a", "b"]\n'
        "velocity = [1, 1, 1]\nfriction_coulomb = [1.5, 0.25, 0.1]\n"
    )
    return f"{tmp_path}/"


def simulated(robot):
    described = simulated_arm(robot)
    spec = new_spec(1e-3, file_of(described))
    arm = mount_arm(spec, described)
    spec.option.gravity = [0.0, 0.0, -9.81]
    return spec.compile(), arm.flange.name


@pytest.fixture(params=["panda", "slider", "wam7"])
def robot(request):
    return request.getfixturevalue("slider") if request.param == "slider" else request.param


def test_inertia_bias_and_flange_are_those_of_the_controllers_model(robot):
    arm = ArmModel.load(robot, gravity=[0.0, 0.0, -9.81])
    model, flange = simulated(robot)
    data, M = mujoco.MjData(model), np.zeros((arm.nv, arm.nv))
    rng = np.random.default_rng(0)
    for _ in range(10):
        data.qpos[:], data.qvel[:] = rng.uniform(-1.5, 1.5, (2, arm.nv))
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, M)
        state = arm.update(data.qpos, data.qvel)
        np.testing.assert_allclose(M, state.M, atol=1e-6)
        np.testing.assert_allclose(data.qfrc_bias, state.h, atol=1e-5)
        np.testing.assert_allclose(data.site(flange).xpos, state.translation, atol=1e-8)
        np.testing.assert_allclose(data.site(flange).xmat.reshape(3, 3), state.rotation, atol=1e-8)


def test_a_command_beyond_the_torque_limit_acts_as_the_limit(robot):
    arm = ArmModel.load(robot)
    model, _ = simulated(robot)
    data = mujoco.MjData(model)
    for sign in (1.0, -1.0):
        data.ctrl[:] = sign * 1e4
        mujoco.mj_forward(model, data)
        np.testing.assert_allclose(data.qfrc_actuator, sign * arm.torque_limit)
        data.ctrl[:] = sign * 0.5 * arm.torque_limit
        mujoco.mj_forward(model, data)
        np.testing.assert_allclose(data.qfrc_actuator, sign * 0.5 * arm.torque_limit)


def test_a_moving_joint_rubs_with_its_coulomb_friction_and_a_resting_one_sticks(robot):
    arm = ArmModel.load(robot)
    model, _ = simulated(robot)
    model.opt.gravity[:] = 0.0
    # The iterations of a scene are few, for the sake of speed; here the law itself is asked.
    model.opt.iterations = 500
    data = mujoco.MjData(model)
    middle = 0.5 * (np.clip(arm.q_lower, -3.0, 3.0) + np.clip(arm.q_upper, -3.0, 3.0))
    for sign in (1.0, -1.0):
        # So fast that the friction does not stop a light wrist within the step.
        data.qpos[:], data.qvel[:] = middle, 30.0 * sign
        mujoco.mj_forward(model, data)
        data.qfrc_applied[:] = data.qfrc_bias - data.qfrc_passive
        mujoco.mj_forward(model, data)
        np.testing.assert_allclose(data.qfrc_constraint, -sign * arm.friction_coulomb, atol=1e-6)
    # The friction of the engine yields a little, so a joint creeps instead of standing still.
    speeds = []
    for coulomb in (arm.friction_coulomb, np.zeros(arm.nv)):
        model.dof_frictionloss[:] = coulomb
        mujoco.mj_resetData(model, data)
        data.qpos[:], data.ctrl[:] = middle, 0.9 * arm.friction_coulomb
        for _ in range(200):
            mujoco.mj_step(model, data)
        speeds.append(np.abs(data.qvel).max())
    assert speeds[0] < 0.05 * speeds[1]


def test_viscous_friction_and_drives_are_those_of_the_folder(robot):
    arm = ArmModel.load(robot)
    model, _ = simulated(robot)
    np.testing.assert_allclose(np.reshape(model.dof_damping, (arm.nv, -1))[:, 0], arm.friction_viscous)
    np.testing.assert_allclose(model.dof_frictionloss, arm.friction_coulomb)
    np.testing.assert_allclose(model.dof_armature, arm.pinocchio_model.armature)
    limited = model.jnt_limited.astype(bool)
    np.testing.assert_array_equal(limited, np.isfinite(arm.q_lower))
    np.testing.assert_allclose(model.jnt_range[limited], np.column_stack([arm.q_lower, arm.q_upper])[limited])


def test_links_that_fit_together_do_not_press_on_one_another():
    model, _ = simulated("panda")
    data = mujoco.MjData(model)
    for q in simulated_arm("panda").postures:
        data.qpos[:] = q
        mujoco.mj_forward(model, data)
        assert data.ncon == 0
    folded = np.array([0.0, 1.7, 0.0, -3.0, 0.0, 3.7, 0.0])
    data.qpos[:] = folded
    mujoco.mj_forward(model, data)
    assert data.ncon > 0


def test_links_beside_the_table_are_derived_where_none_are_stated():
    described = simulated_arm("panda")
    assert isinstance(described.source, ArmBodies)
    assert described.beside_table == ("base", "panda_link1", "panda_link2")
    assert simulated_arm("wam7").beside_table == ("base_link", "link1", "link2", "link3")


def test_a_changed_folder_gives_the_changed_arm(slider):
    before = simulated_arm(slider)
    file = f"{slider}robot.toml"
    with open(file, encoding="utf-8") as opened:
        text = opened.read()
    with open(file, "w", encoding="utf-8") as opened:
        opened.write(text.replace("1.5, 0.25", "1.5, 0.75"))
    assert before.source.bodies[2].joint.coulomb == 0.25
    assert simulated_arm(slider).source.bodies[2].joint.coulomb == 0.75


def test_an_mjcf_for_the_simulation_that_is_not_the_arm_is_refused(tmp_path):
    for name in ("wam7.urdf", "wam7.xml", "robot.toml"):
        (tmp_path / name).write_bytes(path("wam7", name).read_bytes())
    text = (tmp_path / "wam7.xml").read_text()
    (tmp_path / "wam7.xml").write_text(text.replace('<motor name="j3" joint="j3"', '<motor name="j3" joint="j2"'))
    described = simulated_arm(f"{tmp_path}/")
    with pytest.raises(ModelError, match="one motor for each, in this order"):
        mount_arm(mujoco.MjSpec.from_file(file_of(described)), described)
