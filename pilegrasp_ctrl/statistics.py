"""Rates with confidence intervals, tests that compare rates, and Markdown tables."""

from __future__ import annotations

from collections.abc import Iterable

CONFIDENCE = 0.95
"""Confidence of every printed interval [-]; chosen, as usual."""

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


def markdown_row(cells: Iterable[object]) -> str:
    """Return one line of a Markdown table; a bar inside a cell is escaped."""
    return "| " + " | ".join(str(cell).replace("|", "\\|") for cell in cells) + " |"


def markdown_table(header: Iterable[object], rows: Iterable[Iterable[object]] = ()) -> str:
    """Return a Markdown table; without rows, its head for rows that are printed one by one."""
    names = list(header)
    return "\n".join([markdown_row(names), "|" + "---|" * len(names), *map(markdown_row, rows)])
