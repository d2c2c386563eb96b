"""One figure or table of the paper: its conditions, and the function that draws it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from matplotlib.figure import Figure

from pilegrasp_ctrl.scenarios.paper.charts import LIGHT, PAGE, Palette
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.study.charts import svg_element
from pilegrasp_ctrl.study.condition import Condition

USUAL = 50
"""Number of attempts at a condition; the paper's in simulation (V-A)."""
CELL = 20
"""Number of attempts in a cell of a grid whose cells are judged together, or that is reported only."""
FINE = 100
"""Number of attempts where a rate is compared with 95 %, and at each condition of the strategies."""


@dataclass(frozen=True, slots=True)
class ExperimentCondition:
    """One condition of an experiment.

    Attributes:
        condition: Condition to run.
        attempts: Number of attempts.
    """

    condition: Condition
    attempts: int = USUAL

    def shortened(self, attempts: int | None) -> int:
        """Return the number of attempts in a run that is limited to `attempts`; None gives the ledger's number."""
        return self.attempts if attempts is None else min(self.attempts, attempts)


@dataclass(frozen=True, slots=True)
class Experiment:
    """A figure or table of the paper.

    Attributes:
        name: Name on the command line.
        title: Title of one line.
        paper: Result that the paper reports.
        conditions: Conditions to run.
        draw: Function from the evidence and a palette to the figure.
        extra: Whether its conditions are no grasps of the paper's, such as null models.
    """

    name: str
    title: str
    paper: str
    conditions: tuple[ExperimentCondition, ...]
    draw: Callable[[Evidence, Palette], Figure]
    extra: bool = False

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
