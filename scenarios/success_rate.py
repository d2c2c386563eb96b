"""Print the success rate for two numbers of objects, with its 95 % interval, like `pilegrasp sweep`.

Usage: python scenarios/success_rate.py [FOLDER]. A second run does only the missing attempts.
"""

import sys
from pathlib import Path

import pilegrasp_ctrl as pg
from pilegrasp_ctrl.study.condition import conditions
from pilegrasp_ctrl.study.summary import summarise

SEEDS = range(2)
"""Seeds of the piles; more seeds make the interval narrower."""


def main(folder: Path) -> None:
    """Run two seeds of piles of 5 and of 18 spheres, and print a line for each count."""
    varied = conditions("spheres_wall", vary={"pile.count": (5, 18)})
    with pg.run_study([(condition, seed) for condition in varied for seed in SEEDS], folder) as store:
        for row in summarise(store):
            interval = f"95 % interval {row.ci_low:.0%} to {row.ci_high:.0%}"
            print(f"{row.condition['pile.count']} objects: {row.successes} of {row.n} held ({interval})")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out/success_rate"))
