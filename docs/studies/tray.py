"""Run the shovel with trays of several shapes on 18 light balls beside a wall, and print what each held.

Usage: python docs/studies/tray.py FOLDER FIRST LAST [JOBS]

FOLDER holds the shapes, as folders of hands, and a study, as `pilegrasp sweep` makes it; attempts that it holds are not
run again. The paper's shovel held light balls in 85 % of its attempts, and 8.75 % of all that it held were several at
once (V-D).
"""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import tomli_w

from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.hand_folder import parameters
from pilegrasp_ctrl.statistics import markdown_table
from pilegrasp_ctrl.study.condition import Condition
from pilegrasp_ctrl.study.run import run_study
from script import run_script, seed_range, show_progress
from six_conditions import counts

SHAPE = ("width", "wall_height", "thickness", "length")
"""Dimensions of the tray, as `[scoop]` of the shovel's robot.toml calls them. The leading edge is as high as every
plate is thick."""

TRAY_BANDS = {"width": (60, 120), "wall_height": (10, 50), "thickness": (3, 8), "length": (65, 110)}
"""Ends of the bands of these dimensions [mm]; the paper's Fig. 5 admits a rim as well as walls of a ball's height."""

SHAPES = (
    (120, 50, 3, 110),
    (90, 50, 3, 110),
    (75, 50, 3, 110),
    (60, 50, 3, 110),
    (90, 50, 8, 110),
    (75, 50, 6, 110),
    (68, 50, 5, 110),
    (75, 50, 5, 90),
    (75, 50, 8, 90),
    (75, 50, 6, 80),
    (75, 50, 8, 80),
    (60, 50, 3, 80),
    (60, 50, 3, 65),
)
"""Trays that are compared [mm]."""

WALL_SHARE = 0.7
"""Length of the side walls over that of the tray [-]; see the shovel's README."""


def tray(folder: Path, **dimensions: float) -> Path:
    """Write the folder of a shovel whose tray has other `dimensions` [mm], and return its path.

    The side walls and the foot about which it tilts follow the length.
    """
    made: dict[str, Any] = copy.deepcopy(parameters("shovel"))
    scoop = made["scoop"]
    scoop |= {name: value / 1e3 for name, value in dimensions.items()}
    scoop["wall_length"], made["use"]["heel"] = WALL_SHARE * scoop["length"], scoop["length"]
    place = folder / "-".join(["tray", *(f"{name}-{value:g}" for name, value in dimensions.items())])
    place.mkdir(parents=True, exist_ok=True)
    (place / "robot.toml").write_text(tomli_w.dumps(made), encoding="utf-8")
    return place


def main(folder: Path, first: int, last: int, jobs: int = 1) -> None:
    """Run the missing attempts, and print the counts of every shape."""
    seeds = seed_range(first, last)
    conditions: dict[tuple[int, ...], Condition] = {}
    for shape in SHAPES:
        keys = {"hand": f"{tray(folder, **dict(zip(SHAPE, shape, strict=True)))}"}
        conditions[shape] = Condition(load_scenario("spheres_wall", keys), keys)
    attempts = [(condition, seed) for seed in seeds for condition in conditions.values()]
    with run_study(attempts, folder / "study", jobs=jobs, progress=show_progress) as store:
        rows = [
            (*(f"{value}" for value in shape), counts(store.attempts([(condition, seed) for seed in seeds])))
            for shape, condition in conditions.items()
        ]
    print(markdown_table(("width [mm]", "walls [mm]", "lip [mm]", "length [mm]", "held +several"), rows))


if __name__ == "__main__":
    run_script(main)
