"""Run six conditions of the hand with the code of one commit, and print the counts of every commit that was run.

Usage: python docs/studies/six_conditions.py FOLDER ROW [FIRST LAST JOBS]

FOLDER/ROW becomes a study, as `pilegrasp sweep` makes it; ROW may be a number and the commit, such as 1-0a50f88.
Attempts that it holds are not run again, so a run may be interrupted, or be done in pieces with a growing LAST. Seeds
are common to all rows: 10000 to 10039 by default.
"""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from pilegrasp_ctrl.scenarios.paper.conditions import grasp
from pilegrasp_ctrl.statistics import markdown_table
from pilegrasp_ctrl.study.attempt import AttemptRow
from pilegrasp_ctrl.study.condition import Condition
from pilegrasp_ctrl.study.run import run_study
from pilegrasp_ctrl.study.store import StudyStore
from script import run_script, seed_range, show_progress

HARD = {"strategy__speed": 0.25, "strategy__grasp_force": 25.0}
"""Speed [m/s] and F_grasp [N] of the paper's second push of heavy balls in a corner (V-F)."""

CONDITIONS: dict[str, Condition] = {
    "18 light, wall": grasp("light_sphere"),
    "18 heavy, wall": grasp("heavy_sphere"),
    "14 cylinders, wall": grasp("cylinder"),
    "14 cubes, wall": grasp("cube"),
    "18 heavy, corner, 17 N": grasp("heavy_sphere", "corner"),
    "18 heavy, corner, 25 N": grasp("heavy_sphere", "corner", **HARD),
}
"""The six conditions by name: the paper's hand at alpha = beta = 0 (claims C1, C2 and C10)."""


def counts(rows: list[AttemptRow]) -> str:
    """Return attempts held and, behind a +, those of them with several objects."""
    held, several = sum(row.success for row in rows), sum(row.success and row.grasped > 1 for row in rows)
    return f"{held} +{several} of {len(rows)}" if rows else "-"


def reasons(rows: list[AttemptRow]) -> Counter[str]:
    """Return how often each reason ended an attempt without success."""
    failed = [row for row in rows if not row.success]
    return Counter(row.error or str((row.result or {}).get("reason")) for row in failed)


def table(folder: Path) -> str:
    """Return a line for each row of the folder: the counts of each condition, and the mean processor time."""
    lines = []
    for place in sorted(folder.iterdir()):
        with StudyStore(place) as store:
            rows, costs = store.attempts(), store.costs()
        groups = [
            [row for row in rows if row.config_hash == condition.config_hash] for condition in CONDITIONS.values()
        ]
        cost = sum(processor for processor, _ in costs.values()) / max(len(costs), 1)
        lines.append((place.name, *map(counts, groups), f"{cost:.2f}"))
    return markdown_table(("row", *CONDITIONS, "processor time [s]"), lines)


def main(folder: Path, row: str, first: int = 10000, last: int = 10040, jobs: int = 1) -> None:
    """Run the missing attempts; print the reasons of this row's failures, and the table of all rows."""
    # Conditions take turns, so that an interrupted run has equally many seeds of each.
    attempts = [(condition, seed) for seed in seed_range(first, last) for condition in CONDITIONS.values()]
    with run_study(attempts, folder / row, jobs=jobs, progress=show_progress) as store:
        for name, condition in CONDITIONS.items():
            found = store.attempts([(condition, seed) for seed in seed_range(first, last)])
            for reason, number in reasons(found).most_common():
                print(f"{name}: {number} x {reason}")
    print(table(folder))


if __name__ == "__main__":
    run_script(main)
