"""Intervals, exact tests and Markdown tables: known values and the ends of their ranges."""

import subprocess
import sys

import numpy as np
import pytest
from scipy.stats import fisher_exact, norm

from pilegrasp_ctrl.statistics import (
    LARGE,
    Z_ONE_SIDED,
    markdown_row,
    markdown_table,
    mcnemar,
    p_greater,
    paired_limits,
    wilson,
)


@pytest.mark.parametrize(("successes", "n"), [(49, 50), (1, 2), (18, 20), (500, 1000)])
def test_wilson_agrees_with_the_published_formula(successes, n):
    # Brown, Cai and DasGupta, Statistical Science 16 (2001), p. 107.
    z = norm.ppf(0.975)
    p = successes / n
    middle = (p + z * z / (2 * n)) / (1 + z * z / n)
    half = z / (1 + z * z / n) * (p * (1 - p) / n + z * z / (4 * n * n)) ** 0.5
    assert wilson(successes, n) == pytest.approx((middle - half, middle + half), rel=1e-12)


def test_wilson_of_19_in_20_has_the_values_of_the_tables():
    assert wilson(19, 20) == pytest.approx((0.7639, 0.9911), abs=5e-5)


@pytest.mark.parametrize("n", [1, 20, 10_000])
def test_wilson_reaches_0_or_1_if_all_attempts_fail_or_succeed(n):
    (none_low, none_high), (all_low, all_high) = wilson(0, n), wilson(n, n)
    # Both ends in closed form: z² / (n + z²).
    width = norm.ppf(0.975) ** 2 / (n + norm.ppf(0.975) ** 2)
    assert (none_low, none_high) == pytest.approx((0.0, width))
    assert (all_low, all_high) == pytest.approx((1.0 - width, 1.0))
    assert none_low >= 0.0
    assert all_high <= 1.0


def test_wilson_of_no_attempts_is_the_whole_range():
    assert wilson(0, 0) == (0.0, 1.0)


def test_the_exact_test_is_sharper_than_fishers_and_less_than_twice():
    fisher = fisher_exact([[18, 12], [2, 8]], alternative="greater").pvalue
    assert 0.5 * fisher < p_greater(18, 20, 12, 20) < fisher


def test_the_exact_test_gives_barnards_value():
    # Barnard, Nature 156 (1945), p. 177: three of three against none of three, p = 1 / 64.
    assert p_greater(3, 3, 0, 3) == pytest.approx(1.0 / 64.0, rel=1e-6)


def test_a_rate_that_is_not_higher_gives_1():
    assert p_greater(12, 20, 18, 20) == 1.0
    assert p_greater(9, 10, 18, 20) == 1.0
    assert p_greater(0, 0, 0, 20) == p_greater(20, 20, 0, 0) == 1.0


def test_large_samples_are_compared_by_two_proportions():
    assert LARGE < 200 * 200
    pooled = 280 / 400
    z = (0.75 - 0.65) / (pooled * (1 - pooled) * 2 / 200) ** 0.5
    assert p_greater(150, 200, 130, 200) == pytest.approx(norm.sf(z), rel=1e-9)


def test_a_table_has_a_head_and_a_line_for_each_row():
    assert markdown_table(("a", "b"), [(1, "x"), (2.5, "")]) == "| a | b |\n|---|---|\n| 1 | x |\n| 2.5 |  |"
    assert markdown_table(["a"]) == "| a |\n|---|"


def test_a_bar_in_a_cell_does_not_end_it():
    assert markdown_row(["fig06|fig07", 1]) == "| fig06\\|fig07 | 1 |"


def test_importing_the_module_does_not_import_scipy():
    code = "import sys, pilegrasp_ctrl.statistics; sys.exit('scipy' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_mcnemar_counts_the_pairs_that_differ_alone():
    assert mcnemar(0, 0) == 1.0
    assert mcnemar(5, 0) == pytest.approx(2 / 32)
    assert mcnemar(3, 9) == mcnemar(9, 3) == pytest.approx(2 * sum((1, 12, 66, 220)) / 4096)


def test_the_interval_of_a_paired_difference_covers_it_as_often_as_it_says():
    random = np.random.default_rng(4)
    chances = (0.55, 0.25, 0.1, 0.1)
    found = [paired_limits(tuple(map(int, random.multinomial(60, chances)))) for _ in range(300)]
    assert np.mean([low <= 0.15 <= high for low, high in found]) > 0.92
    assert paired_limits((0, 0, 0, 0)) == (-1.0, 1.0)
    low, high = paired_limits((50, 0, 0, 0))
    assert low < 0.0 < high < 0.1
    assert paired_limits((30, 12, 2, 6)) == pytest.approx([-end for end in paired_limits((30, 2, 12, 6))][::-1])
    narrow, wide = paired_limits((30, 12, 2, 6), Z_ONE_SIDED), paired_limits((30, 12, 2, 6))
    assert wide[0] < narrow[0] < 0.2 < narrow[1] < wide[1]
