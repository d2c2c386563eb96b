"""MuJoCo's CG and Newton by the size of the pile, in whole attempts and in piles that settle: tables of numerics.md.

Usage: python compare_contact_solvers.py [SEEDS]
"""

from functools import partial

from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.statistics import markdown_table
from script import run_script
from solver_by_size import HEADER, SOLVERS, attempt, fall, rows

PILES = (
    *(("spheres_wall", count) for count in (5, 18, 30, 60, 90)),
    ("cylinders_wall", 14),
    ("cubes_wall", 14),
)


def main(seeds: int = 3) -> None:
    """Print both tables: of attempts, and of the same objects settling in their frame."""
    for run, solvers in ((attempt, SOLVERS), (fall, SOLVERS[:2])):
        print(markdown_table(HEADER))
        for name, count in PILES:
            scenario = load_scenario(name, {"pile.count": count})
            label = f"{count} {name.partition('_')[0]}"
            print("\n".join(rows(label, partial(run, scenario), range(seeds), solvers)), flush=True)
        print()


if __name__ == "__main__":
    run_script(main)
