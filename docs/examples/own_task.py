"""Add a task of your own: the elbow keeps its distance from a post, while the tool goes to a pose."""

import numpy as np

import pilegrasp_ctrl as pg
from pilegrasp_ctrl.robots import panda_urdf


class ElbowDistance:
    """A spring and a damper for the elbow's distance from a point. Any object with `rows` is a task."""

    def __init__(self, point, distance):
        self.point, self.distance = point, distance

    def rows(self, state):
        elbow = state.frame("panda_link4")  # J, Jdot_v, translation, rotation and twist of any frame
        way, v = elbow.translation - self.point, elbow.twist[:3]
        distance = np.linalg.norm(way)
        n = way / distance
        wanted = 100.0 * (self.distance - distance) - 20.0 * n @ v  # [m/s²]
        wanted -= (v @ v - (n @ v) ** 2) / distance  # what the distance gains where the elbow passes the post
        return pg.Objective([n @ elbow.J[:3]], [wanted - n @ elbow.Jdot_v[:3]])  # asks for A a = b


arm = pg.ArmModel.from_urdf(panda_urdf(), tool_frame="panda_hand_tcp", joints=7)
home = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
start = arm.update(home, np.zeros(7))
post = start.frame("panda_link4").translation - [0.0, 0.3, 0.0]
tool = pg.FrameTask(arm)
tool.set_target(start.pose.moved([0.0, 0.2, 0.0]))  # [m]
controller = pg.InverseDynamics(arm, tasks=[tool, ElbowDistance(post, 0.36), pg.PostureTask(arm, home)])
*_, last = pg.ArmSimulation(arm).run(lambda seen: controller.step(seen).command.torque, home, 3.0)
end = arm.update(last.q, last.v)
distance = np.linalg.norm(end.frame("panda_link4").translation - post)
error = np.linalg.norm(end.translation - tool.target.pose.translation)
print(f"elbow: {1000 * distance:.1f} mm from the post, wanted 360 mm; tool: {1000 * error:.2f} mm from its target")
