"""Rates and paired differences with confidence intervals, tests that compare rates, and Markdown tables."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

CONFIDENCE = 0.95
"""Confidence of every printed interval [-]; chosen, as usual."""

Z_95 = 1.959963984540054
"""Normal quantile of a two-sided interval of 95 %."""
Z_ONE_SIDED = 1.6448536269514722
"""Normal quantile of a one-sided bound of 95 %."""

Pairs = tuple[int, int, int, int]
"""Numbers of pairs that succeeded in both, in the first only, in the second only, and in neither."""

LARGE = 20_000
"""Product of two sample sizes above which the chi-squared test replaces Barnard's [-]; chosen. Barnard's test then
takes seconds, and the approximate test is as good."""


def wilson(successes: int, n: int) -> tuple[float, float]:
    """Return the 95 % Wilson interval of a rate, without correction for continuity; [0, 1] if `n` is 0.

    Wilson, J. Am. Stat. Assoc. 22 (1927), p. 209.
    """
    from scipy.stats import binomtest

    if n == 0:
        return 0.0, 1.0
    interval = binomtest(successes, n).proportion_ci(CONFIDENCE, "wilson")
    return float(interval.low), float(interval.high)


def ratio_interval(tops: Sequence[float], bottoms: Sequence[float]) -> tuple[float, float, float] | None:
    """Return a ratio of two sums over the same things, with its 95 % interval; None without things or with a sum of 0.

    The interval is Student's, for a ratio that is made linear (W. G. Cochran, Sampling Techniques, 1977, ch. 6). The
    values are not negative, so neither is the interval; for one thing it is unknown, from 0 to infinity.
    """
    from scipy.special import stdtrit

    n, total = len(bottoms), math.fsum(bottoms)
    if not n or total <= 0.0:
        return None
    ratio = math.fsum(tops) / total
    if n == 1:
        return ratio, 0.0, math.inf
    spread = math.fsum((top - ratio * bottom) ** 2 for top, bottom in zip(tops, bottoms, strict=True))
    margin = float(stdtrit(n - 1, 0.5 + 0.5 * CONFIDENCE)) * math.sqrt(spread * n / (n - 1)) / total
    return ratio, max(0.0, ratio - margin), ratio + margin


def p_greater(successes: int, n: int, other_successes: int, other_n: int) -> float:
    """Return the one-sided p-value of the hypothesis that the first rate is higher.

    The test is Barnard's exact one (Nature 156, 1945, p. 177). Samples above `LARGE` are compared by the chi-squared
    test of two proportions, halved. A first rate that is not the higher one gives 1; so does an empty sample.
    """
    from scipy.stats import barnard_exact, chi2_contingency

    if n == 0 or other_n == 0 or successes / n <= other_successes / other_n:
        return 1.0
    table = [[successes, other_successes], [n - successes, other_n - other_successes]]
    if n * other_n <= LARGE:
        return float(barnard_exact(table, alternative="greater").pvalue)
    return 0.5 * float(chi2_contingency(table, correction=False).pvalue)


def mcnemar(wins: int, losses: int) -> float:
    """Return the two-sided p-value of the hypothesis that of two paired rates one is higher, by McNemar's exact test.

    Args:
        wins: Pairs in which the first alone succeeded.
        losses: Pairs in which the second alone succeeded.
    """
    from scipy.stats import binomtest

    return float(binomtest(wins, wins + losses).pvalue) if wins + losses else 1.0


def score_limits(successes: int, n: int, z: float) -> tuple[float, float]:
    """Return the limits of Wilson's interval for a normal quantile z; see `wilson`."""
    rate, share = successes / n, z * z / n
    middle = (rate + 0.5 * share) / (1.0 + share)
    half = z * math.sqrt(rate * (1.0 - rate) / n + 0.25 * share / n) / (1.0 + share)
    return max(0.0, middle - half), min(1.0, middle + half)


def paired_limits(pairs: Pairs, z: float = Z_95) -> tuple[float, float]:
    """Return the limits of the difference of two paired rates, first minus second; (-1, 1) without pairs.

    Newcombe's hybrid score interval, his method 10 (Stat. Med. 17, 1998, p. 2635).

    Args:
        pairs: Table of the pairs.
        z: Normal quantile of each limit; the default gives an interval of 95 %.
    """
    both, first, second, neither = pairs
    n = both + first + second + neither
    if n == 0:
        return -1.0, 1.0
    rate, other = (both + first) / n, (both + second) / n
    low, high = score_limits(both + first, n, z)
    other_low, other_high = score_limits(both + second, n, z)
    margins = (both + first) * (second + neither) * (both + second) * (first + neither)
    product = both * neither - first * second
    centred = max(product - 0.5 * n, 0.0) if product > 0 else float(product)
    correlation = centred / math.sqrt(margins) if margins else 0.0

    def away(a: float, b: float) -> float:
        return math.sqrt(max(0.0, a * a - 2.0 * correlation * a * b + b * b))

    difference = rate - other
    return (
        difference - away(rate - low, other_high - other),
        difference + away(high - rate, other - other_low),
    )


def markdown_row(cells: Iterable[object]) -> str:
    """Return one line of a Markdown table; a bar inside a cell is escaped."""
    return "| " + " | ".join(str(cell).replace("|", "\\|") for cell in cells) + " |"


def markdown_table(header: Iterable[object], rows: Iterable[Iterable[object]] = ()) -> str:
    """Return a Markdown table; without rows, its head for rows that are printed one by one."""
    names = list(header)
    return "\n".join([markdown_row(names), "|" + "---|" * len(names), *map(markdown_row, rows)])
