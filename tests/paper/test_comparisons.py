"""Exact tests keep their level and find what is there; intervals cover; Holm's correction is Holm's."""

import math

import numpy as np
import pytest
from scipy.stats import fisher_exact, norm

from pilegrasp_ctrl.scenarios.paper.comparisons import (
    holm,
    p_higher,
    p_mcnemar,
    p_not_inferior,
    stratified_limits,
)
from pilegrasp_ctrl.statistics import paired_limits, wilson

LEVEL = 0.05
STUDIES = 2000


def shares(p_value, tables):
    """Return the share of tables that are significant; equal tables are tested once."""
    found, counts = np.unique(tables, axis=0, return_counts=True)
    significant = [p_value(*map(int, table)) < LEVEL for table in found]
    return float(counts[significant].sum() / counts.sum())


def pairs_of(first, second, both, n=50, studies=STUDIES, seed=0):
    """Return tables of pairs (both, first only, second only, neither) of simulated studies."""
    random = np.random.default_rng(seed)
    return random.multinomial(n, [both, first - both, second - both, 1.0 - first - second + both], studies)


@pytest.mark.parametrize("rate", [0.5, 0.9, 0.98])
def test_independent_equal_rates_are_called_different_in_at_most_one_study_of_twenty(rate):
    random = np.random.default_rng(1)
    tables = [[a, 50, b, 50] for a, b in random.binomial(50, rate, (STUDIES, 2))]
    assert shares(p_higher, tables) <= LEVEL + 0.01


def test_a_difference_of_thirty_points_is_found_in_most_studies():
    random = np.random.default_rng(2)
    tables = [
        [a, 50, b, 50]
        for a, b in zip(random.binomial(50, 0.9, STUDIES), random.binomial(50, 0.6, STUDIES), strict=True)
    ]
    assert shares(p_higher, tables) > 0.85


def test_the_independent_test_is_fishers_and_the_reverse_is_the_other_side():
    table = [[18, 12], [2, 8]]
    assert p_higher(18, 20, 12, 20) == pytest.approx(fisher_exact(table, alternative="greater").pvalue)
    assert p_higher(12, 20, 18, 20) == pytest.approx(fisher_exact(table, alternative="less").pvalue)
    assert p_higher(0, 0, 3, 20) == p_higher(3, 20, 0, 0) == 1.0


@pytest.mark.parametrize("both", [0.36, 0.55])
def test_paired_equal_rates_are_called_different_in_at_most_one_study_of_twenty(both):
    assert shares(p_mcnemar, pairs_of(0.6, 0.6, both)[:, 1:3]) <= LEVEL + 0.01


def test_pairs_that_agree_otherwise_make_a_difference_easier_to_find():
    alike, unlike = (shares(p_mcnemar, pairs_of(0.85, 0.65, both)[:, 1:3]) for both in (0.64, 0.55))
    assert alike > 0.85
    assert alike > unlike + 0.1


def test_mcnemars_test_counts_the_pairs_that_differ():
    assert p_mcnemar(5, 0) == pytest.approx(1.0 / 32.0)
    assert p_mcnemar(0, 5) == p_mcnemar(0, 0) == 1.0


@pytest.mark.parametrize(("first", "second", "both"), [(0.9, 0.8, 0.78), (0.95, 0.95, 0.91), (0.6, 0.5, 0.4)])
def test_the_interval_of_a_paired_difference_covers_it(first, second, both):
    found, counts = np.unique(pairs_of(first, second, both), axis=0, return_counts=True)
    limits = [paired_limits(tuple(map(int, table))) for table in found]
    covered = [low <= first - second <= high for low, high in limits]
    assert counts[covered].sum() / counts.sum() > 0.94


def test_paired_limits_are_wilsons_where_nothing_is_paired_but_the_sample():
    assert paired_limits((50, 0, 0, 0)) == pytest.approx((-(1.0 - wilson(50, 50)[0]), 1.0 - wilson(50, 50)[0]))
    assert paired_limits((0, 0, 0, 0)) == (-1.0, 1.0)
    low, high = paired_limits((30, 10, 2, 8))
    assert low < 8 / 50 < high
    assert paired_limits((30, 2, 10, 8)) == pytest.approx((-high, -low))


def six(first, second, both, seed):
    """Return 200 simulated studies of six strata with 100 pairs each."""
    return pairs_of(first, second, both, 100, 1200, seed).reshape(200, 6, 4)


def not_inferior(studies):
    found = [p_not_inferior(tuple(tuple(map(int, pairs)) for pairs in study), 0.1) < LEVEL for study in studies]
    return float(np.mean(found))


def test_a_loss_of_the_whole_margin_passes_in_at_most_one_study_of_twenty():
    assert not_inferior(six(0.8, 0.9, 0.75, 4)) < LEVEL + 0.04


def test_equal_strategies_pass_and_a_loss_of_twenty_points_is_found():
    assert not_inferior(six(0.9, 0.9, 0.85, 5)) > 0.99
    worse = six(0.7, 0.9, 0.68, 6)
    p = [p_not_inferior(tuple(tuple(map(int, pairs)) for pairs in study), 0.1) for study in worse[:50]]
    assert np.mean([1.0 - value < LEVEL for value in p]) > 0.95


def test_the_limit_reaches_the_margin_at_the_p_value():
    strata = ((90, 2, 5, 3), (80, 5, 10, 5))
    p = p_not_inferior(strata, 0.1)
    assert stratified_limits(strata, norm.isf(p))[1] == pytest.approx(-0.1, abs=1e-9)
    mean, low, high = stratified_limits(strata, 1.0)
    assert mean == pytest.approx(-8.0 / 200.0)
    assert low < mean < high
    assert p_not_inferior((), 0.1) == 0.5


def test_holm_multiplies_the_smallest_by_the_number_and_keeps_the_order():
    assert holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])
    assert holm([0.5, 0.6]) == [1.0, 1.0]
    assert holm([]) == []


def test_with_holm_one_study_of_twenty_at_most_has_any_wrong_verdict():
    random = np.random.default_rng(7)
    wrong = [min(holm(list(row))) < LEVEL for row in random.uniform(size=(STUDIES, 20))]
    assert np.mean(wrong) < LEVEL + 3.0 * math.sqrt(LEVEL / STUDIES)
