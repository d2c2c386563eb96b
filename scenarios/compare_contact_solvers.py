"""MuJoCo's CG and Newton by the size of the pile, in whole attempts and in piles that settle: tables of numerics.md.

Usage: python compare_contact_solvers.py [SEEDS]
"""

import sys
from functools import partial

from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.experiments.physics.solver_by_size import HEADER, SOLVERS, attempt, fall, rows

PILES = (
    *(("spheres_wall", count) for count in (5, 18, 30, 60, 90)),
    ("cylinders_wall", 14),
    ("cubes_wall", 14),
)


def main() -> None:
    """Print both tables: of attempts, and of the same objects settling in their frame."""
    seeds = range(int(sys.argv[1]) if sys.argv[1:] else 3)
    for run, solvers in ((attempt, SOLVERS), (fall, SOLVERS[:2])):
        print(HEADER)
        for name, count in PILES:
            scenario = load_scenario(name, {"pile.count": count})
            label = f"{count} {name.partition('_')[0]}"
            print("\n".join(rows(label, partial(run, scenario), seeds, solvers)), flush=True)
        print()


if __name__ == "__main__":
    main()
