"""Print how well the operational-space controller tracks lines, arcs and steps on two arms, as Markdown tables.

No physics engine is involved: the plant is the arm's equations of motion with joint friction, and it differs from the
controller's model in one thing at a time. Everything takes a minute or two on one core.
"""

import argparse
import sys

from pilegrasp_ctrl.exceptions import PilegraspError
from tracking import ARMS, SPEEDS, STEPS, tracking_table


def main() -> None:
    """Measure what was asked for; everything where nothing was."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--arms", nargs="+", choices=ARMS, default=ARMS)
    parser.add_argument("--speeds", nargs="*", type=float, default=SPEEDS, help="of lines and arcs [m/s]")
    parser.add_argument("--steps", nargs="*", type=float, default=STEPS, help="sizes of the steps [m]")
    parser.add_argument("--jobs", type=int, default=1, help="number of processes")
    options = parser.parse_args()
    try:
        print(tracking_table(options.arms, options.speeds, options.steps, jobs=options.jobs).markdown())
    except PilegraspError as error:
        sys.exit(f"error: {error}")


if __name__ == "__main__":
    main()
