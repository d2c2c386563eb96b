"""Print the peak force of the table [N] if the floor rises more toward the wall than the arm assumes.

Usage: python docs/studies/table_force.py [FIRST LAST]

FIRST and LAST are the range of seeds. The floor is level, so the piles are those of `spheres_wall`; the arm assumes
that it slopes down by the error. This takes some minutes on one core.
"""

from itertools import product
from pathlib import Path
from statistics import fmean
from tempfile import TemporaryDirectory

import pilegrasp_ctrl as pg
from pilegrasp_ctrl.analysis.motion import table_force
from pilegrasp_ctrl.statistics import markdown_row, markdown_table
from script import run_script, seed_range

ERRORS = (0.0, 0.5, 1.0, 2.0)
"""Errors of the slope [deg]; chosen."""

CONTROLLERS = {"impedance": "impedance", "operational space": "operational_space", "stiff": "operational_space"}
"""Controller of each row."""


def main(first: int = 0, last: int = 5) -> None:
    """Print the mean force for each error, the number of successes, and the number of primitives that failed."""
    seeds = seed_range(first, last)
    print(markdown_table(("hand", "controller", *(f"{error:g}°" for error in ERRORS), "held", "failed")))
    with TemporaryDirectory() as folder:
        gains = Path(folder, "stiff.toml")
        gains.write_text(f"[motion]\nstiffness = {6 * [10000.0]}\n", encoding="utf-8")
        for hand, (name, controller) in product(("rbo_hand2", "shovel"), CONTROLLERS.items()):
            keys = {"hand": hand, "controller.kind": controller} | (
                {"controller.gains": gains} if name == "stiff" else {}
            )
            cells, results = [], []
            for error in ERRORS:
                wrong = keys | {"support.tilt_deg": error, "support.slope_error_deg": error}
                results += (new := [pg.run("spheres_wall", seed=s, record=True, overrides=wrong) for s in seeds])
                forces = [table_force(result.recording) for result in new if result.recording]
                cells.append(f"{fmean(force['peak'] for force in forces if force):.1f}")
            failed = sum(outcome.status == "failed" for result in results for outcome in result.outcomes)
            held = sum(result.success for result in results)
            print(markdown_row((hand, name, *cells, held, failed)), flush=True)


if __name__ == "__main__":
    run_script(main)
