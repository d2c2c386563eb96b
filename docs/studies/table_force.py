"""Peak force of the table [N] where the floor rises more toward the wall than the arm knows, as a Markdown table.

The floor is level, so that the piles are those of `spheres_wall`; the arm takes it to slope down by the error. Some
minutes on one core. Usage: python table_force.py [FIRST LAST], the range of seeds
"""

from pathlib import Path
from statistics import fmean
from tempfile import TemporaryDirectory

import pilegrasp_ctrl as pg
from pilegrasp_ctrl.analysis.motion import table_force
from script import run_script, seed_range

ERRORS = (0.0, 0.5, 1.0, 2.0)
CONTROLLERS = {"impedance": "impedance", "operational space": "operational_space", "stiff": "operational_space"}


def main(first: int = 0, last: int = 5) -> None:
    """Print the mean for each error, and of all attempts how many held something and in how many a primitive failed."""
    seeds = seed_range(first, last)
    print("", "end-effector", "controller", *(f"{error:g}°" for error in ERRORS), "held", "failed", "", sep=" | ")
    with TemporaryDirectory() as folder:
        gains = Path(folder, "stiff.toml")
        gains.write_text(f"[motion]\nstiffness = {6 * [10000.0]}\n", encoding="utf-8")
        for hand, (name, kind) in [(hand, each) for hand in ("rbo_hand2", "shovel") for each in CONTROLLERS.items()]:
            keys = {"hand": hand, "controller.kind": kind} | ({"controller.gains": gains} if name == "stiff" else {})
            cells, results = [], []
            for error in ERRORS:
                wrong = keys | {"support.tilt_deg": error, "support.slope_error_deg": error}
                results += (new := [pg.run("spheres_wall", seed=s, record=True, overrides=wrong) for s in seeds])
                forces = [table_force(result.recording) for result in new if result.recording]
                cells.append(f"{fmean(force['peak'] for force in forces if force):.1f}")
            failed = sum(outcome.status == "failed" for result in results for outcome in result.outcomes)
            print("", hand, name, *cells, sum(result.success for result in results), failed, "", sep=" | ", flush=True)


if __name__ == "__main__":
    run_script(main)
