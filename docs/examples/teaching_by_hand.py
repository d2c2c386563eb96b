"""Teach by hand: the arm weighs nothing, can be led, and stays where you leave it."""

import numpy as np

import pilegrasp_ctrl as pg
from pilegrasp_ctrl.robots import panda_urdf

arm = pg.ArmModel.from_urdf(panda_urdf(), tool_frame="panda_hand_tcp", joints=7)
home = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
# No springs, only dampers; the controller compensates gravity by itself.
dampers = pg.JointImpedance(stiffness=0.0, damping=[8.0, 8.0, 4.0, 4.0, 0.5, 0.5, 0.05])  # [N·m·s/rad]
controller = pg.InverseDynamics(arm, tasks=[pg.JointTask(arm, stiffness=dampers)])
goal = arm.update(home, np.zeros(7)).translation + np.array([0.1, 0.2, 0.1])  # where the hand leads the tool [m]
holding = True


def hand(pose, twist):
    force = 100.0 * (goal - pose.translation) - 20.0 * twist[:3] if holding else np.zeros(3)  # [N]
    return np.concatenate((force, np.zeros(3)))


def torque(observation):
    global holding
    holding = observation.time < 3.0
    return controller.step(observation).command.torque


samples = list(pg.ArmSimulation(arm, environment=hand).run(torque, home, 6.0))
led, left = (arm.update(sample.q, sample.v).translation for sample in (samples[1500], samples[-1]))
print(f"the hand left the tool {1000 * np.linalg.norm(led - goal):.1f} mm from where it was led")
print(f"in the next 3 s the tool moved by {1000 * np.linalg.norm(left - led):.1f} mm")
