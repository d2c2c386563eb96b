"""Print what the hands do, measured on the bench and in one attempt each; with a file's name, draw it there.

Usage: python hand_table.py [FIGURE.png]
"""

from pathlib import Path

from hand_figures import hand_figure
from pilegrasp_ctrl.validation.hand.hand_table import measurements
from pilegrasp_ctrl.validation.hand.measurement import markdown
from script import run_script


def main(*figures: Path) -> None:
    """Measure; a minute on one core."""
    print(markdown(measurements()))
    for file in figures:
        hand_figure(file)


if __name__ == "__main__":
    run_script(main)
