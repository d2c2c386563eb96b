"""Print and draw the success of `spheres_wall` with each of the most uncertain numbers 30 % lower and higher.

Usage: python docs/studies/sensitivity.py FOLDER FIRST LAST [JOBS]

FOLDER becomes a study, as `pilegrasp sweep` makes it; attempts that it holds are not run again.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from matplotlib.figure import Figure

from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.statistics import markdown_table
from pilegrasp_ctrl.study.condition import Condition
from pilegrasp_ctrl.study.run import StudyProgress, run_study
from pilegrasp_ctrl.study.summary import SummaryRow, summarise
from script import run_script, seed_range

SCENARIO = "spheres_wall"
"""Scenario of every attempt."""

SHARE = 0.3
"""Share by which each uncertain number is lowered and raised [-]; chosen."""

ENCLOSED_AIR = 1.1
"""Stiffness from the air enclosed in a finger, over the bending stiffness [-]; derived in the hand's README."""

UNCERTAIN = (
    "hand_model.bending_stiffness",
    "hand_model.closing_moment",
    "hand_model.fingertip_radius",
    "hand_model.friction",
    "pile.friction",
    "hand_model.lateral_stiffness",
)
"""Numbers without a published measurement on which the grasp depends; see the hand's README and `docs/objects.md`."""

GOAL = 0.85
"""Success rate that the figure marks [-]; chosen."""

ABOVE, BELOW, SHIPPED = "#1f5f99", "#c2571a", "#999999"
"""Colours of rows that reach the goal, that miss it, and of the scenario as shipped."""


def conditions() -> list[Condition]:
    """Return the scenario as shipped, stiffened fingers, and every uncertain number lowered and raised."""
    varied: list[dict[str, float]] = [{}, {"hand_model.inflation_stiffness": ENCLOSED_AIR}]
    varied += [{key: factor} for key in UNCERTAIN for factor in (1.0 - SHARE, 1.0 + SHARE)]
    return [Condition(load_scenario(SCENARIO, keys), keys) for keys in varied]


def label(row: SummaryRow) -> str:
    """Return the name of a condition in the table."""
    varied = [f"`{key}` = {value:g}" for key, value in row.condition.items() if key != "scenario"]
    return ", ".join(varied) or "as shipped"


def draw(rows: Sequence[SummaryRow], file: Path) -> None:
    """Draw the success of every condition with its interval."""
    figure = Figure(figsize=(8.0, 0.32 * len(rows) + 1.0), layout="constrained")
    axes = figure.subplots()
    for place, row in enumerate(rows):
        shipped = label(row) == "as shipped"
        color = SHIPPED if shipped else ABOVE if row.rate >= GOAL else BELOW
        axes.plot([100.0 * row.ci_low, 100.0 * row.ci_high], [place, place], color=color, linewidth=2.0)
        axes.plot([100.0 * row.rate], [place], "o", color=color)
    axes.axvline(100.0 * GOAL, color=SHIPPED, linestyle=":", linewidth=1.0)
    axes.set_yticks(range(len(rows)), [label(row).replace("`", "") for row in rows])
    axes.invert_yaxis()
    axes.set(xlabel="success [%], 95 % Wilson interval", xlim=(0.0, 101.0))
    figure.savefig(file, dpi=110)


def main(folder: Path, first: int, last: int, jobs: int = 1) -> None:
    """Run the missing attempts, print the table and draw FOLDER/sensitivity.png."""

    def show(progress: StudyProgress) -> None:
        print(f"{progress.done} of {progress.total}", file=sys.stderr)

    # Conditions take turns, so that an interrupted run has equally many seeds of each.
    attempts = [(condition, seed) for seed in seed_range(first, last) for condition in conditions()]
    with run_study(attempts, folder, jobs=jobs, progress=show) as store:
        rows = summarise(store, attempts)
    cells = [(label(row), f"{row.successes} of {row.n}", f"{row.ci_low:.0%} to {row.ci_high:.0%}") for row in rows]
    print(markdown_table(("", "success", "95 % interval"), cells))
    draw(rows, folder / "sensitivity.png")


if __name__ == "__main__":
    run_script(main)
