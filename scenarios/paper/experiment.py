"""One figure or table of the paper: what is run for it, and how it is drawn."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.study.condition import Condition

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pilegrasp_ctrl.scenarios.paper.palette import Palette

ROBOT, SIMULATED = 20, 50
"""Attempts at a condition: those that the paper ran on its robot, and those that it simulated (V-A)."""


@dataclass(frozen=True, slots=True)
class Row:
    """One condition of an experiment.

    Attributes:
        condition: what is run.
        attempts: the paper's number of them.
        share: of a shortened run's attempts. Less than 1 where conditions are judged together, as the cells of a grid.
    """

    condition: Condition
    attempts: int
    share: float = 1.0

    def shortened(self, attempts: int | None) -> int:
        """Return how many attempts to make where no more than `attempts` are wanted; None leaves the paper's number."""
        return self.attempts if attempts is None else min(self.attempts, math.ceil(self.share * attempts))


@dataclass(frozen=True, slots=True)
class Experiment:
    """A figure or table of the paper.

    Attributes:
        name: by which it is asked for.
        title: one line.
        paper: what the paper reports.
        rows: what is run.
        draw: makes the figure.
    """

    name: str
    title: str
    paper: str
    rows: tuple[Row, ...]
    draw: Callable[[Evidence, Palette], Figure]
