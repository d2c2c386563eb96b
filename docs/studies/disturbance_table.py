"""Print what a payload and wrong friction cost in accuracy, without and with the disturbance observer."""

import numpy as np

import pilegrasp_ctrl as pg
from example_arm import HOME, example_arm
from pilegrasp_ctrl.control.disturbance_observer import ObservedController
from pilegrasp_ctrl.plant.tracking import simulate_tracking

PANDA = [1.0, 1.0, 1.0, 1.0, 0.5, 0.5, 0.5]  # its URDF has no friction; chosen, Coulomb [N·m], viscous [N·m·s/rad]
CASES = [(payload, factor) for payload in (0.0, 0.5) for factor in (1.0, 1.3, 0.7)]


def accuracy(arm: pg.ArmModel, payload: float, factor: float, posture: np.ndarray | None, bandwidth: float) -> str:
    """Follow 0.16 m at 0.1 m/s and rest for 2 s; return rms on the way and error at the end [mm]."""
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
    for arm in (pg.ArmModel.load("wam7"), panda):
        for case in CASES:
            columns = ((HOME[arm.name], 0.0), (HOME[arm.name], 10.0), (HOME[arm.name], 50.0), (None, 10.0))
            print("", arm.name, *case, *(accuracy(arm, *case, *column) for column in columns), "", sep=" | ")


if __name__ == "__main__":
    main()
