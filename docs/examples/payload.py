"""Tell the controller what the hand carries after a grasp."""

import numpy as np

import pilegrasp_ctrl as pg
from pilegrasp_ctrl.robots import panda_urdf

arm = pg.ArmModel.from_urdf(panda_urdf(), tool_frame="panda_hand_tcp", joints=7)
home = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
pose = arm.update(home, np.zeros(7)).pose
controller = pg.OperationalSpaceController(arm, posture=home)
loaded = pg.ArmSimulation(arm, payload=1.5)  # [kg], which the model does not know


def sag():
    controller.reset()
    *_, last = loaded.run(lambda seen: controller.step(seen, pose).command.torque, home, 1.0)
    return np.linalg.norm(arm.update(last.q, last.v).translation - pose.translation)


before = sag()
controller.set_payload(mass=1.5, center_of_mass=[0.0, 0.0, 0.0])  # [kg], [m] in tool axes
print(f"the tool sags by {1000 * before:.2f} mm; once the payload is known, by {1000 * sag():.4f} mm")
