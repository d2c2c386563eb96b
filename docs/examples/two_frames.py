"""Move two frames of one arm: the tool follows a line, and the elbow swings to the side."""

import numpy as np

import pilegrasp_ctrl as pg
from pilegrasp_ctrl.robots import panda_urdf

arm = pg.ArmModel.from_urdf(panda_urdf(), tool_frame="panda_hand_tcp", joints=7)
home = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
start = arm.update(home, np.zeros(7))
elbow_start = start.frame("panda_link4").pose
line = pg.StraightLine(start.pose, displacement=[0.0, 0.0, 0.15], speed=0.1)  # [m], [m/s]
swing = pg.StraightLine(elbow_start, displacement=[0.0, 0.08, 0.0], speed=0.05)

# One joint is left beside the tool's six axes, so the elbow gets one axis: y.
tool = pg.FrameTask(arm)
elbow = pg.FrameTask(arm, "panda_link4", mask=[0, 1, 0, 0, 0, 0], weight=0.1)
controller = pg.InverseDynamics(arm, tasks=[tool, elbow])


def torque(observation):
    tool.set_target(line.at(observation.time))
    elbow.set_target(swing.at(observation.time))
    return controller.step(observation).command.torque


*_, last = pg.ArmSimulation(arm).run(torque, home, max(line.duration, swing.duration) + 0.5)
end = arm.update(last.q, last.v)
side = end.frame("panda_link4").translation[1] - elbow_start.translation[1]
print(f"tool: {1000 * np.linalg.norm(end.translation - line.end.translation):.2f} mm from the end of its line")
print(f"elbow: {1000 * side:.1f} mm to the side")
