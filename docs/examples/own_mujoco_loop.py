"""Follow a line with the Panda of your own MuJoCo scene: model of the arm, controller, loop."""

from pathlib import Path

import mujoco
import numpy as np

import pilegrasp_ctrl as pg

model = mujoco.MjModel.from_xml_path(str(Path(__file__).with_name("panda_scene.xml")))
data = mujoco.MjData(model)
joints = [model.joint(f"panda_joint{n}") for n in range(1, 8)]
q = [int(joint.qposadr[0]) for joint in joints]  # where the arm's joints stand in data.qpos,
v = [int(joint.dofadr[0]) for joint in joints]  # in data.qvel
motors = [model.actuator(f"motor{n}").id for n in range(1, 8)]  # and their motors in data.ctrl

home = np.array([0.0, -0.6, 0.0, -2.1, 0.0, 1.5, 0.785])
data.qpos[q] = home
arm = pg.ArmModel.from_mjcf(model, "panda_hand_tcp", joints=7, velocity_limit=[2.1] * 4 + [2.6] * 3)
controller = pg.OperationalSpaceController(arm, posture=home, rate=500.0)
line = pg.StraightLine(start=arm.update(home, np.zeros(7)).pose, displacement=[-0.1, 0.2, -0.1], speed=0.1)
error = 0.0
while data.time < line.duration:
    observation = pg.Observation(data.time, data.qpos[q], data.qvel[v])
    data.ctrl[motors] = controller.step(observation, line.at(data.time)).command.torque
    mujoco.mj_step(model, data, nstep=2)  # two steps of 1 ms are one period of the controller
    mujoco.mj_kinematics(model, data)
    error = max(error, np.linalg.norm(data.site("panda_hand_tcp").xpos - line.at(data.time).pose.translation))
print(f"largest distance of the tool from its reference: {1000 * error:.3f} mm")
