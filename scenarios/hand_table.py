"""Print what the hands do, measured on the bench and in one attempt each; with a file's name, draw it there.

Usage: python hand_table.py [FIGURE.png]
"""

from pathlib import Path

from pilegrasp_ctrl.experiments.hand.figures import hand_figure
from pilegrasp_ctrl.experiments.hand.hand_table import measurements
from pilegrasp_ctrl.experiments.hand.measurement import markdown
from pilegrasp_ctrl.scenarios._script import run_script


def main(*figures: Path) -> None:
    """Measure; a minute on one core."""
    print(markdown(measurements()))
    for file in figures:
        hand_figure(file)


if __name__ == "__main__":
    run_script(main)
