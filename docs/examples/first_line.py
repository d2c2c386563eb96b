"""Follow a straight line with the tool of the Panda."""

import numpy as np

import pilegrasp_ctrl as pg
from pilegrasp_ctrl.robots import panda_urdf

arm = pg.ArmModel.from_urdf(panda_urdf(), tool_frame="panda_hand_tcp", joints=7)
home = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
# The posture says what the seventh joint is for; without one, the elbow drifts.
controller = pg.OperationalSpaceController(arm, posture=home, rate=500.0)
start = arm.update(home, np.zeros(7)).pose
line = pg.StraightLine(start, displacement=[0.0, 0.3, -0.1], speed=0.2)  # [m], [m/s]


def torque(observation):
    return controller.step(observation, line.at(observation.time)).command.torque


error = 0.0
for sample in pg.ArmSimulation(arm).run(torque, home, line.duration, rate=500.0):
    tool = arm.update(sample.q, sample.v).translation
    error = max(error, np.linalg.norm(tool - line.at(sample.time).pose.translation))
print(f"largest distance of the tool from its line: {1000 * error:.2f} mm")
