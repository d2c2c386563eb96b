"""Success of `spheres_wall` with each of the most uncertain numbers 30 % lower and higher.

Usage: python sensitivity.py FOLDER FIRST LAST [JOBS]. What FOLDER/sensitivity.csv holds already is not run again.
"""

import sys
from pathlib import Path

from hand_figures import sensitivity_figure
from hand_sensitivity import conditions, markdown, measure, rows
from script import run_script, seed_range


def main(folder: Path, first: int, last: int, jobs: int = 1) -> None:
    """Run the missing attempts, print the table and draw FOLDER/sensitivity.png."""
    file = folder / "sensitivity.csv"
    for condition, seed in measure(conditions(), seed_range(first, last), jobs, file):
        print(condition.label, seed, file=sys.stderr)
    counted = rows(file)
    print(markdown(counted))
    sensitivity_figure(counted, file.with_suffix(".png"))


if __name__ == "__main__":
    run_script(main)
