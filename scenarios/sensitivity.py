"""Success of `spheres_wall` with each of the most uncertain numbers 30 % lower and higher.

Usage: python sensitivity.py FOLDER FIRST LAST [JOBS]. What FOLDER/sensitivity.csv holds already is not run again.
"""

import sys
from pathlib import Path

from pilegrasp_ctrl.experiments.hand.figures import sensitivity_figure
from pilegrasp_ctrl.experiments.hand.sensitivity import conditions, markdown, measure, rows


def main() -> None:
    """Run the missing attempts, print the table and draw FOLDER/sensitivity.png."""
    folder, first, last, *jobs = sys.argv[1:]
    file = Path(folder, "sensitivity.csv")
    for condition, seed in measure(conditions(), range(int(first), int(last)), int(*jobs or "1"), file):
        print(condition.label, seed, file=sys.stderr)
    counted = rows(file)
    print(markdown(counted))
    sensitivity_figure(counted, file.with_suffix(".png"))


if __name__ == "__main__":
    main()
