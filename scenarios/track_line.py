"""Follow a straight line with the WAM and its joint friction, without scene or contact; print the tracking error."""

import numpy as np
import pinocchio as pin

import pilegrasp_ctrl as pg

RATE = 1000.0  # [Hz]


def main() -> None:
    """Integrate the arm's equations of motion under the controller's torques."""
    arm = pg.ArmModel.load("wam7")
    model = arm.pinocchio_model
    data = model.createData()
    controller = pg.OperationalSpaceController(arm, gains=pg.MotionGains(stiffness=900.0), rate=RATE)  # [1/s²]
    q, v = np.array([0.0, 0.6, 0.0, 1.9, 0.0, -0.9, 0.0]), np.zeros(arm.nv)
    line = pg.StraightLine(start=arm.update(q, v).pose, displacement=[0.0, 0.3, 0.0], speed=0.1)  # [m], [m/s]
    errors = []
    for time in np.arange(0.0, line.duration, 1.0 / RATE):
        reference = line.at(time)
        errors.append(np.linalg.norm(arm.update(q, v).translation - reference.pose.translation))
        torque = controller.step(pg.Observation(time, q, v), reference).command.torque
        friction = arm.friction_coulomb * np.tanh(v / 0.01) + arm.friction_viscous * v
        v = v + pin.aba(model, data, q, v, torque - friction) / RATE
        q = q + v / RATE
    rms = np.sqrt(np.mean(np.square(errors)))
    print(f"{line.duration:.1f} s: tracking error rms {1e3 * rms:.2f} mm, peak {1e3 * max(errors):.2f} mm")


if __name__ == "__main__":
    main()
