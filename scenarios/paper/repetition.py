"""The probability that a fresh study of the same size repeats each verdict."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.scenarios.paper.judgement import Finding
from pilegrasp_ctrl.scenarios.paper.verdicts import Judged, second_pass, shown_outcome

DRAWS = 1000
"""Number of fresh studies; chosen, for a standard error of at most 1.6 points."""
SEED = 20210530
"""Seed of the draws; any number will do."""


@dataclass(frozen=True, slots=True)
class Repetition:
    """How often fresh studies repeated a ledger.

    Attributes:
        rows: Probability for each row that a fresh study gives it the same outcome.
        hold: Mean number of rows that hold in a fresh study, of those that count.
        least: Number of those rows that hold in all but one of twenty fresh studies.
        most: Number of those rows above which only one of twenty fresh studies lies.
    """

    rows: dict[str, float]
    hold: float
    least: int
    most: int

    def as_dict(self) -> dict[str, float]:
        """Return what a fresh study would find, as plain JSON values."""
        return {"hold": self.hold, "least": self.least, "most": self.most}


def repetition(
    evidence: Evidence,
    first_pass: Callable[[Evidence], Mapping[str, Finding]],
    judged: Mapping[str, tuple[Judged, ...]],
    counting: tuple[str, ...],
    draws: int = DRAWS,
) -> Repetition:
    """Return how often fresh studies repeat the ledger: a parametric bootstrap through the judging code.

    Args:
        evidence: Attempts of the study.
        first_pass: Function from evidence to the findings of all rows.
        judged: Statements of all rows in the study itself.
        counting: Names of the rows whose holding is counted.
        draws: Number of fresh studies.
    """
    random = np.random.default_rng(SEED)
    found = {name: shown_outcome(parts) for name, parts in judged.items()}
    same = dict.fromkeys(found, 0)
    held = []
    for _ in range(draws):
        outcomes = {
            name: shown_outcome(parts) for name, parts in second_pass(first_pass(evidence.fresh(random))).items()
        }
        for name, outcome in outcomes.items():
            same[name] += outcome == found[name]
        held.append(sum(outcomes[name] == "holds" for name in counting))
    held.sort()
    return Repetition(
        {name: count / draws for name, count in same.items()},
        sum(held) / draws,
        held[int(0.05 * draws)],
        held[int(0.95 * draws)],
    )
