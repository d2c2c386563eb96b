"""Run the two pushes into a corner and the cylinders over the thickness of the fingertips, and draw the rates.

Usage: python docs/studies/tip_thickness.py FOLDER FIRST LAST [JOBS]

FOLDER becomes a study, as `pilegrasp sweep` makes it; attempts that it holds are not run again.
"""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from pilegrasp_ctrl.scenarios.paper.figures_nulls import tip_factor
from pilegrasp_ctrl.statistics import markdown_table, wilson
from pilegrasp_ctrl.study.run import run_study
from script import run_script, seed_range, show_progress
from sensitivity import SEEDS, varied
from six_conditions import CONDITIONS, counts

RADII = (3.5, 5.0, 6.0, 7.0, 8.0, 8.75)
"""Radii of the fingertips [mm]; the band of the hand's README, with the largest as a taper leaves it."""

NAMES = ("14 cylinders, wall", "18 heavy, corner, 17 N", "18 heavy, corner, 25 N")
"""Conditions of the figure; see `six_conditions.py`."""

COLORS = ("#999999", "#1f5f99", "#c2571a")
"""Their colours."""


def main(folder: Path, first: int = SEEDS[0], last: int = SEEDS[1], jobs: int = 1) -> None:
    """Run the missing attempts, print the counts and draw FOLDER/tip_thickness.png."""
    seeds = seed_range(first, last)
    cells = {
        (name, radius): varied(CONDITIONS[name], {"hand_model.fingertip_radius": tip_factor(radius / 1e3)})
        for name in NAMES
        for radius in RADII
    }
    attempts = [(condition, seed) for seed in seeds for condition in cells.values()]
    figure = Figure(figsize=(6.0, 3.2), layout="constrained")
    axes = figure.subplots()
    lines = []
    with run_study(attempts, folder, jobs=jobs, progress=show_progress) as store:
        for name, color in zip(NAMES, COLORS, strict=True):
            rows = [store.attempts([(cells[name, radius], seed) for seed in seeds]) for radius in RADII]
            rates = [sum(row.success for row in some) / len(some) for some in rows]
            bounds = [wilson(sum(row.success for row in some), len(some)) for some in rows]
            axes.fill_between(RADII, *zip(*bounds, strict=True), color=color, alpha=0.15, linewidth=0.0)
            axes.plot(RADII, rates, "o-", color=color, label=name)
            lines.append((name, *map(counts, rows)))
    axes.set(xlabel="radius of the fingertips [mm]", ylabel="held", ylim=(0.0, 1.0))
    axes.legend(frameon=False, fontsize=8)
    figure.savefig(folder / "tip_thickness.png", dpi=110)
    print(markdown_table(("", *(f"{radius:g} mm" for radius in RADII)), lines))


if __name__ == "__main__":
    run_script(main)
