"""Evidence that stays valid however often one looks, and stops whenever one likes.

A gambler bets on differences x in [-1, 1]. Each round multiplies the capital by 1 + b x, for a bet b in (0, 1). If the
mean of x is not above 0, given the past, the expected capital does not grow. By Ville's inequality the capital then
ever exceeds 1 / a with a probability of at most a, whatever rule ends the game. The capital here is the mean over
evenly spaced bets. For differences of -1, 0 and 1 it is Robbins' mixture for the sign test.

H. Robbins, Ann. Math. Stat. 41 (1970), p. 1397; S. R. Howard et al., Ann. Stat. 49 (2021), p. 1055; I. Waudby-Smith and
A. Ramdas, J. R. Stat. Soc. B 86 (2024), p. 1.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ..types import Array

BETS = (np.arange(64) + 0.5) / 64
"""Bets (k,) of which the capital is the mean [-]; chosen, dense enough for a thousand rounds."""

TOLERANCE = 1e-4
"""Accuracy of the ends of an interval [-]; chosen."""


def log_evidence(differences: Array) -> float:
    """Return the logarithm of the capital: large if the mean of the differences is above 0.

    Args:
        differences: (n,) values of at least -1, whose bets begin at the first.
    """
    values, counts = np.unique(np.asarray(differences, dtype=np.float64), return_counts=True)
    if values.size == 0:
        return 0.0
    logs = np.log1p(np.multiply.outer(BETS, values)) @ counts
    top = float(logs.max())
    return top + math.log(float(np.mean(np.exp(logs - top))))


def mean_interval(values: Array, error: float) -> tuple[float, float]:
    """Return an interval that holds the mean of values in [0, 1] at all times, but with the probability `error`.

    Args:
        values: (n,) values in [0, 1].
        error: Probability that the interval ever misses the mean [-].
    """
    values = np.asarray(values, dtype=np.float64)
    bound = math.log(2.0 / error)

    def above(mean: float) -> bool:
        return log_evidence((values - mean) / mean) >= bound

    def below(mean: float) -> bool:
        return log_evidence((mean - values) / (1.0 - mean)) >= bound

    middle = float(values.mean()) if values.size else 0.5
    return _edge(above, 0.0, middle), _edge(below, 1.0, middle)


def lead_interval(differences: Array, error: float) -> tuple[float, float]:
    """Return such an interval for the mean of differences (n,) in [-1, 1]."""
    low, high = mean_interval((np.asarray(differences) + 1.0) / 2.0, error)
    return 2.0 * low - 1.0, 2.0 * high - 1.0


def _edge(refuted: Callable[[float], bool], outer: float, inner: float) -> float:
    """Return the border between means that are refuted, near `outer`, and means that are not."""
    far, near = outer, inner
    while abs(near - far) > TOLERANCE:
        middle = 0.5 * (far + near)
        far, near = (middle, near) if refuted(middle) else (far, middle)
    return far
