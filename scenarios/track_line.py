"""Follow a straight line with the WAM and its joint friction, without scene or contact, and print the tracking error.

Usage: python scenarios/track_line.py
"""

import numpy as np

import pilegrasp_ctrl as pg
from pilegrasp_ctrl.plant.tracking import simulate_tracking

RATE = 1000.0
"""Control rate [Hz]."""


def main() -> None:
    """Close the loop over the arm's equations of motion."""
    arm = pg.ArmModel.load("wam7")
    controller = pg.OperationalSpaceController(arm, gains=pg.MotionGains(stiffness=900.0), rate=RATE)  # [1/s²]
    q = np.array([0.0, 0.6, 0.0, 1.9, 0.0, -0.9, 0.0])
    line = pg.StraightLine(start=arm.update(q, 0.0 * q).pose, displacement=[0.0, 0.3, 0.0], speed=0.1)  # [m], [m/s]
    motion = simulate_tracking(pg.ArmSimulation(arm), controller, line.at, q, line.duration, RATE)
    errors = 1e3 * np.linalg.norm(motion.error[:, :3], axis=1)
    rms = np.sqrt(np.mean(np.square(errors)))
    print(f"{line.duration:.1f} s: tracking error rms {rms:.2f} mm, peak {errors.max():.2f} mm")


if __name__ == "__main__":
    main()
