"""The verdict on the motion pattern (III): four questions about the measures of three conditions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pilegrasp_ctrl.scenarios.paper.judgement import LEVEL
from pilegrasp_ctrl.statistics import wilson

Measures = Sequence[Mapping[str, Any]]
"""Results of `analysis.motion.measure`, one for each attempt at a condition."""

MIN_KNOWN_SHARE = 0.9
"""Smallest share of the successful attempts in which the held object must be known before the grasp; chosen."""


def motion_verdict(measures: Mapping[str, Measures]) -> dict[str, dict[str, Any]]:
    """Return four answers: approach, spread, wall and separation.

    Each answer has a `verdict` ("holds", "fails" or "undecided") and its numbers. Means are compared by
    Student's one-sided t-test at `LEVEL`, two means by Welch's. The share is judged by its value, with the 95 % Wilson
    interval beside it.

    Args:
        measures: Measures of the attempts at the conditions "none", "wall" and "corner".
    """
    everything = [row for condition in ("none", "wall", "corner") for row in measures[condition]]
    approach = {name: measured(rows, "approach_speed") for name, rows in measures.items()}
    spread = {name: measured(rows, "spread_speed") for name, rows in measures.items()}
    return {
        "approach": _all_positive(approach),
        "spread": _all_positive(spread),
        "wall": _less(spread["wall"], spread["none"]),
        "separation": _share([bool(row["agreed"]) for row in everything if row["held"]]),
    }


def measured(measures: Measures, name: str) -> list[float]:
    """Return a measure of the attempts in which it exists."""
    return [row[name] for row in measures if row[name] is not None]


def _all_positive(samples: Mapping[str, list[float]]) -> dict[str, Any]:
    """Judge whether the mean is positive in every condition; the weakest one decides."""
    from scipy.stats import ttest_1samp

    if min(map(len, samples.values())) < 2:
        return {"verdict": "undecided", "p": None}
    p = {name: float(ttest_1samp(sample, 0.0, alternative="greater").pvalue) for name, sample in samples.items()}
    opposite = any(ttest_1samp(sample, 0.0, alternative="less").pvalue < LEVEL for sample in samples.values())
    worst = max(p.values())
    return {"verdict": "fails" if opposite else "holds" if worst < LEVEL else "undecided", "p": worst}


def _less(first: list[float], second: list[float]) -> dict[str, Any]:
    from scipy.stats import ttest_ind

    if min(len(first), len(second)) < 2:
        return {"verdict": "undecided", "p": None}
    p, opposite = (float(ttest_ind(first, second, equal_var=False, alternative=a).pvalue) for a in ("less", "greater"))
    return {"verdict": "holds" if p < LEVEL else "fails" if opposite < LEVEL else "undecided", "p": p}


def _share(agreed: list[bool]) -> dict[str, Any]:
    if not agreed:
        return {"verdict": "undecided", "n": 0, "agreed": 0, "rate": None, "ci_low": None, "ci_high": None}
    ci_low, ci_high = wilson(sum(agreed), len(agreed))
    rate = sum(agreed) / len(agreed)
    return {
        "verdict": "holds" if rate >= MIN_KNOWN_SHARE else "fails",
        "n": len(agreed),
        "agreed": sum(agreed),
        "rate": rate,
        "ci_low": ci_low,
        "ci_high": ci_high,
    }
