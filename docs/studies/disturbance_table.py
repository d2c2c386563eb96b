"""Print how a payload and wrong friction change the accuracy, without and with the disturbance observer.

Usage: python docs/studies/disturbance_table.py
"""

import numpy as np

import pilegrasp_ctrl as pg
from example_arm import HOME, example_arm
from pilegrasp_ctrl.control.disturbance_observer import ObservedController
from pilegrasp_ctrl.plant.tracking import simulate_tracking
from pilegrasp_ctrl.statistics import markdown_row, markdown_table
from script import run_script

PANDA = [1.0, 1.0, 1.0, 1.0, 0.5, 0.5, 0.5]
"""Coulomb [N·m] and viscous [N·m·s/rad] friction of the Panda; chosen, because its URDF has none."""

CASES = [(payload, factor) for payload in (0.0, 0.5) for factor in (1.0, 1.3, 0.7)]
"""Payload [kg] and friction of the plant over the model's [-] of each row."""

HEADER = ("arm", "payload [kg]", "friction", "no observer", "10 rad/s", "50 rad/s", "10 rad/s, no posture")
"""Columns of the table; the last four hold rms error on the line / error at the end [mm]."""


def accuracy(arm: pg.ArmModel, payload: float, factor: float, posture: np.ndarray | None, bandwidth: float) -> str:
    """Track a line of 0.16 m at 0.1 m/s and a rest of 2 s; return rms error on the line and error at the end [mm]."""
    home = HOME[arm.name]
    line = pg.StraightLine(arm.update(home, 0.0 * home).pose, [0.0, 0.15, 0.05], speed=0.1)
    coulomb, viscous = factor * arm.friction_coulomb, factor * arm.friction_viscous
    plant = pg.ArmSimulation(arm, payload=payload, friction_coulomb=coulomb, friction_viscous=viscous)
    alone = pg.OperationalSpaceController(arm, posture=posture)
    controller = ObservedController(alone, pg.DisturbanceObserver(arm, bandwidth)) if bandwidth else alone
    motion = simulate_tracking(plant, controller, line.at, home, line.duration + 2.0)
    error = 1e3 * np.linalg.norm(motion.error[:, :3], axis=1)
    return f"{np.sqrt(np.mean(error[:-1000] ** 2)):.2f} / {error[-1]:.3f}"


def main() -> None:
    """Measure both arms: no observer, bandwidths of 10 and 50 rad/s, and 10 rad/s without a preferred posture."""
    model = example_arm("panda").arm.pinocchio_model
    panda = pg.ArmModel(model, "panda_hand_tcp", name="panda", friction_coulomb=PANDA, friction_viscous=PANDA)
    print(markdown_table(HEADER))
    for arm in (pg.ArmModel.load("wam7"), panda):
        for case in CASES:
            columns = ((HOME[arm.name], 0.0), (HOME[arm.name], 10.0), (HOME[arm.name], 50.0), (None, 10.0))
            print(markdown_row((arm.name, *case, *(accuracy(arm, *case, *column) for column in columns))))


if __name__ == "__main__":
    run_script(main)
