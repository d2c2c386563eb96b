"""Run the shovel with trays of several shapes on 18 light balls beside a wall, and print what each held.

Usage: python docs/studies/tray.py FOLDER FIRST LAST [JOBS]

FOLDER holds the shapes, as folders of hands, and a study, as `pilegrasp sweep` makes it; attempts that it holds are not
run again. The paper's shovel held light balls in 85 % of its attempts, and 8.75 % of all that it held were several at
once (V-D).
"""

from __future__ import annotations

import copy
import sys
from pathlib import Path
from typing import Any

import tomli_w

from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.hand_folder import parameters
from pilegrasp_ctrl.statistics import markdown_table
from pilegrasp_ctrl.study.condition import Condition
from pilegrasp_ctrl.study.run import StudyProgress, run_study
from script import run_script, seed_range
from six_conditions import counts

WIDTHS = (60, 75, 90, 120)
"""Outer widths of the tray [mm]; the band is 60 to 120."""

WALLS = (10, 25, 50)
"""Heights of its side walls [mm]; the photograph admits a rim as well as walls of a ball's height."""

LIPS = (3,)
"""Thicknesses of its plates, so heights of the leading edge [mm]; the band is 3 to 8."""


def tray(folder: Path, width: int, wall: int, lip: int) -> Path:
    """Write the folder of a shovel with a tray of this shape, and return its path."""
    made: dict[str, Any] = copy.deepcopy(parameters("shovel"))
    made["scoop"] |= {"width": width / 1e3, "wall_height": wall / 1e3, "thickness": lip / 1e3}
    place = folder / f"tray-{width}-{wall}-{lip}"
    place.mkdir(parents=True, exist_ok=True)
    (place / "robot.toml").write_text(tomli_w.dumps(made))
    return place


def main(folder: Path, first: int, last: int, jobs: int = 1) -> None:
    """Run the missing attempts, and print the counts of every shape."""

    def show(progress: StudyProgress) -> None:
        print(f"{progress.done} of {progress.total}", file=sys.stderr)

    seeds = seed_range(first, last)
    conditions: dict[tuple[int, int, int], Condition] = {}
    for shape in ((width, wall, lip) for width in WIDTHS for wall in WALLS for lip in LIPS):
        keys = {"hand": f"{tray(folder, *shape)}"}
        conditions[shape] = Condition(load_scenario("spheres_wall", keys), keys)
    attempts = [(condition, seed) for seed in seeds for condition in conditions.values()]
    with run_study(attempts, folder / "study", jobs=jobs, progress=show) as store:
        rows = [
            (*(f"{value}" for value in shape), counts(store.attempts([(condition, seed) for seed in seeds])))
            for shape, condition in conditions.items()
        ]
    print(markdown_table(("width [mm]", "walls [mm]", "lip [mm]", "held +several"), rows))


if __name__ == "__main__":
    run_script(main)
