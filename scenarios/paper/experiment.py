"""One figure or table of the paper: its conditions, and the function that draws it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from matplotlib.figure import Figure

from pilegrasp_ctrl.scenarios.paper.charts import LIGHT, PAGE, Palette
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.study.charts import svg_element
from pilegrasp_ctrl.study.condition import Condition

ROBOT, SIMULATED = 20, 50
"""Number of attempts at a condition that the paper ran on its robot, and number that it simulated (V-A)."""


@dataclass(frozen=True, slots=True)
class ExperimentCondition:
    """One condition of an experiment.

    Attributes:
        condition: Condition to run.
        attempts: Number of attempts in the paper.
        share: Share of a shortened run's attempts. It is less than 1 if conditions are judged together, such as the
            cells of a grid.
    """

    condition: Condition
    attempts: int
    share: float = 1.0

    def shortened(self, attempts: int | None) -> int:
        """Return the number of attempts in a run that is limited to `attempts`; None gives the paper's number."""
        return self.attempts if attempts is None else min(self.attempts, math.ceil(self.share * attempts))


@dataclass(frozen=True, slots=True)
class Experiment:
    """A figure or table of the paper.

    Attributes:
        name: Name on the command line.
        title: Title of one line.
        paper: Result that the paper reports.
        conditions: Conditions to run.
        draw: Function from the evidence and a palette to the figure.
    """

    name: str
    title: str
    paper: str
    conditions: tuple[ExperimentCondition, ...]
    draw: Callable[[Evidence, Palette], Figure]

    def save_figure(self, evidence: Evidence, folder: Path) -> list[str]:
        """Write the figure as SVG and PNG; return the files' names."""
        names = []
        for suffix, metadata in (("svg", {"Date": None, "Creator": None}), ("png", {"Software": None})):
            names.append(f"{self.name}.{suffix}")
            with LIGHT.style():
                figure = self.draw(evidence, LIGHT)
                figure.savefig(folder / names[-1], dpi=160, facecolor="white", metadata=metadata)
        return names

    def figure_element(self, evidence: Evidence) -> str:
        """Return the figure as an element of a page, in the page's own colours."""
        with PAGE.style():
            return svg_element(self.draw(evidence, PAGE), self.title, PAGE.as_dict(), prefix=f"{self.name}-")
