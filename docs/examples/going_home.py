"""Go to a joint posture from anywhere, at a speed that you choose."""

import numpy as np

import pilegrasp_ctrl as pg
from pilegrasp_ctrl.robots import panda_urdf

arm = pg.ArmModel.from_urdf(panda_urdf(), tool_frame="panda_hand_tcp", joints=7)
home = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
away = np.array([1.2, 0.4, -0.8, -1.3, 0.9, 2.6, -1.0])
controller = pg.InverseDynamics(arm, tasks=[pg.JointTask(arm, home, max_speed=0.5)])  # [rad/s]


def torque(observation):
    return controller.step(observation).command.torque


samples = list(pg.ArmSimulation(arm).run(torque, away, 5.0))
fastest = max(np.abs(sample.v).max() for sample in samples)
print(f"largest distance from home: {np.abs(samples[-1].q - home).max():.5f} rad")
print(f"fastest joint on the way: {fastest:.2f} rad/s")
