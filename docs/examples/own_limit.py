"""Add a limit of your own: the tool stops at a wall, although it is sent beyond."""

import numpy as np

import pilegrasp_ctrl as pg
from pilegrasp_ctrl.robots import panda_urdf


class Wall:
    """Keeps the tool's x below a wall. Any object with `hard` and `rows` is a limit."""

    hard = False  # it gives way where the torques do not suffice

    def __init__(self, x, gain=5.0, horizon=0.004):  # [m], [1/s], two control periods [s]
        self.x, self.gain, self.horizon = x, gain, horizon

    def rows(self, state):
        # At the end of the horizon, the speed toward the wall is at most gain * distance.
        distance, speed = self.x - state.translation[0], state.twist[0]
        most = (self.gain * distance - (1.0 + self.gain * self.horizon) * speed) / self.horizon  # [m/s²]
        return pg.Bounds(state.J[:1], [-np.inf], [most - state.Jdot_v[0]], ("wall",))  # lower <= G a <= upper


arm = pg.ArmModel.from_urdf(panda_urdf(), tool_frame="panda_hand_tcp", joints=7)
home = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
start = arm.update(home, np.zeros(7)).pose
wall, tool, active = Wall(start.translation[0] + 0.05), pg.FrameTask(arm), set()
tool.set_target(start.moved([0.1, 0.1, 0.0]))  # [m], 5 cm beyond the wall
controller = pg.InverseDynamics(arm, [tool, pg.PostureTask(arm, home)], [*pg.limits_of(arm), wall])


def torque(observation):
    output = controller.step(observation)
    active.update(output.active_limits)
    return output.command.torque


xs = [arm.update(sample.q, sample.v).translation[0] for sample in pg.ArmSimulation(arm).run(torque, home, 3.0)]
print(f"smallest distance from the wall: {1000 * (wall.x - max(xs)):.3f} mm; limits: {', '.join(sorted(active))}")
