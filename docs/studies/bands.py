"""Run the six conditions with each uncertain number at the ends of its band, and rank the numbers by their effect.

Usage: python docs/studies/bands.py FOLDER FIRST LAST [JOBS]

FOLDER becomes a study, as `pilegrasp sweep` makes it; attempts that it holds are not run again. The effect of a number
is the largest difference between the rates at its two ends and in the middle, over the six conditions.
"""

from __future__ import annotations

import sys
from pathlib import Path

from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.statistics import markdown_table
from pilegrasp_ctrl.study.condition import Condition
from pilegrasp_ctrl.study.run import StudyProgress, run_study
from pilegrasp_ctrl.study.store import StudyStore
from script import run_script, seed_range
from six_conditions import CONDITIONS, counts

SEEDS = (10000, 10040)
"""First seed, and the one after the last."""

BANDS: dict[str, tuple[float, float]] = {
    "hand_model.fingertip_radius": (0.519, 1.481),
    "hand_model.pad_give": (0.667, 1.333),
    "hand_model.twist_stiffness": (0.47, 2.2),
    "hand_model.bending_stiffness": (0.5, 1.3),
    "hand_model.lateral_stiffness": (0.5, 2.0),
    "hand_model.closing_moment": (0.7, 1.3),
    "hand_model.friction": (1.0, 1.5),
    "pile.friction": (0.75, 1.2),
    "sim.joint_friction": (0.7, 1.3),
    "sim.arm_mass": (0.97, 1.03),
}
"""Uncertain numbers: factors at the two ends of their bands, as the hand's README, docs/objects.md and the arm's
robot.toml state or imply them. An end of 1 is the shipped value."""


def varied(condition: Condition, key: str, factor: float) -> Condition:
    """Return a condition with one number at an end of its band."""
    keys = {**condition.varied, key: factor} if factor != 1.0 else dict(condition.varied)
    return Condition(load_scenario("spheres_wall", keys), keys)


def lines(store: StudyStore, seeds: range) -> list[tuple[str, ...]]:
    """Return the rows of the table: for each number its counts at both ends, the largest effect first."""
    found: list[tuple[float, tuple[str, ...]]] = []
    for key, ends in BANDS.items():
        cells, effect = [f"`{key}` = {ends[0]:g}, {ends[1]:g}"], 0.0
        for condition in CONDITIONS.values():
            three = [condition, *(varied(condition, key, end) for end in ends)]
            rows = [store.attempts([(each, seed) for seed in seeds]) for each in three]
            rates = [sum(row.success for row in some) / max(len(some), 1) for some in rows]
            effect = max(effect, max(rates) - min(rates))
            cells.append(f"{counts(rows[1])}; {counts(rows[2])}")
        found.append((effect, (*cells, f"{effect:.0%}")))
    return [cells for _, cells in sorted(found, key=lambda pair: -pair[0])]


def main(folder: Path, first: int = SEEDS[0], last: int = SEEDS[1], jobs: int = 1) -> None:
    """Run the missing attempts, and print the table."""

    def show(progress: StudyProgress) -> None:
        print(f"{progress.done} of {progress.total}", file=sys.stderr)

    seeds = seed_range(first, last)
    wanted = list(CONDITIONS.values())
    wanted += [varied(each, key, end) for key, ends in BANDS.items() for end in ends for each in CONDITIONS.values()]
    attempts = [(condition, seed) for seed in seeds for condition in wanted]
    with run_study(attempts, folder, jobs=jobs, progress=show) as store:
        middle = [counts(store.attempts([(each, seed) for seed in seeds])) for each in CONDITIONS.values()]
        rows = [("as shipped", *middle, ""), *lines(store, seeds)]
    print(markdown_table(("", *CONDITIONS, "effect"), rows))


if __name__ == "__main__":
    run_script(main)
