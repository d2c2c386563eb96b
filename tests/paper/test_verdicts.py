"""The second pass over the ledger and its repetition, on synthetic studies with known answers."""

import numpy as np
import pytest

from paper_world import Made, rows
from pilegrasp_ctrl.scenarios.paper.conditions import grasp
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence, Sample, pairs
from pilegrasp_ctrl.scenarios.paper.judgement import (
    Finding,
    Judgement,
    Significance,
    judge_at_least,
    judge_greater,
    judge_not_less,
)
from pilegrasp_ctrl.scenarios.paper.repetition import repetition
from pilegrasp_ctrl.scenarios.paper.verdicts import combine_verdicts, second_pass, shown_outcome
from pilegrasp_ctrl.study.attempt import AttemptRow

ONE, OTHER, THIRD = grasp("light_sphere"), grasp("heavy_sphere"), grasp("cylinder")


def row_of(*parts):
    return Finding(tuple(parts), {})


def verdict(*parts):
    return combine_verdicts(second_pass({"row": row_of(*parts)})["row"])


HOLDS, FAILS, UNDECIDED = (Judgement("", outcome) for outcome in ("holds", "fails", "undecided"))


def test_one_failing_statement_fails_a_row_and_an_undecided_one_leaves_it_undecided():
    assert verdict(HOLDS, UNDECIDED, FAILS) == "fails"
    assert verdict(HOLDS, UNDECIDED) == "undecided"
    assert verdict(HOLDS, HOLDS) == "holds"
    assert verdict() == "undecided"


def test_a_calibrated_statement_counts_for_nothing_and_a_row_of_them_is_calibrated():
    fitted = Judgement("", "fails", calibrated=True)
    told = Judgement("", reported=True)
    assert verdict(HOLDS, fitted, told) == "holds"
    assert verdict(fitted, told) == "calibrated"
    assert verdict(told) == "reported"
    assert shown_outcome(second_pass({"row": row_of(fitted, told)})["row"]) == "fails"


def test_holms_correction_counts_all_tests_of_the_ledger_but_the_reported_ones():
    tested = Judgement("", None, Significance(0.03, 0.99))
    told = Judgement("", None, Significance(0.03, 0.99), reported=True)
    alone = second_pass({"a": row_of(tested), "b": row_of(told)})
    assert [alone[name][0].outcome for name in "ab"] == ["holds", "holds"]
    both = second_pass({"a": row_of(tested), "b": row_of(tested), "c": row_of(told)})
    assert [part.outcome for name in "ab" for part in both[name]] == ["undecided"] * 2
    assert both["a"][0].test.p == pytest.approx(0.06)


def test_a_failure_needs_the_corrected_test_of_the_reverse():
    lost = Judgement("", None, Significance(0.99, 0.03))
    assert second_pass({"a": row_of(lost)})["a"][0].outcome == "fails"
    assert second_pass({"a": row_of(lost), "b": row_of(lost)})["a"][0].outcome == "undecided"


def study(*rates, n=50, random=None):
    """Return evidence at three conditions, drawn at these rates."""
    found = []
    for condition, rate in zip((ONE, OTHER, THIRD), rates, strict=False):
        held = random.random(n) < rate if random else np.arange(n) < round(rate * n)
        results = [{"success": bool(s), "grasped": int(s), "outcomes": []} for s in held]
        found += [AttemptRow(condition.config_hash, seed, {}, result, None) for seed, result in enumerate(results)]
    return Evidence.from_rows(found, [ONE, OTHER, THIRD])


def judge(evidence):
    """Return a small ledger: a threshold, two comparisons and one "at least"."""
    one, other, third = map(evidence.sample, (ONE, OTHER, THIRD))
    return {
        "reaches": row_of(judge_at_least("one", one, 0.95)),
        "above": row_of(judge_greater("one", one, "other", other, paired=True)),
        "beyond": row_of(judge_greater("one", one, "third", third)),
        "keeps up": row_of(judge_not_less("other", other, "third", third)),
    }


def outcomes(*rates, studies=150):
    """Return the share of simulated studies with each outcome, by row and outcome."""
    random = np.random.default_rng(5)
    found = {}
    for _ in range(studies):
        for name, parts in second_pass(judge(study(*rates, random=random))).items():
            found[name, parts[0].outcome] = found.get((name, parts[0].outcome), 0.0) + 1.0 / studies
    return found


def test_equal_rates_are_called_different_in_at_most_one_ledger_of_twenty():
    found = outcomes(0.8, 0.8, 0.8)
    for name in ("above", "beyond"):
        assert found.get((name, "holds"), 0.0) + found.get((name, "fails"), 0.0) < 0.05
    assert found.get(("keeps up", "fails"), 0.0) < 0.05


def test_a_gap_of_forty_points_is_found_and_an_opposite_one_fails():
    found = outcomes(0.95, 0.55, 0.55)
    assert found["above", "holds"] > 0.9
    assert found["beyond", "holds"] > 0.9
    opposite = outcomes(0.5, 0.9, 0.9)
    assert opposite["above", "fails"] > 0.9
    assert opposite.get(("reaches", "holds"), 0.0) == 0.0


def repeated(*rates, draws=300):
    evidence = study(*rates)
    return repetition(evidence, judge, second_pass(judge(evidence)), ("reaches", "above"), draws)


def test_what_is_on_the_brink_repeats_in_half_of_the_studies_and_what_is_plain_in_nearly_all():
    found = repeated(0.96, 0.5, 0.5)
    assert 0.5 < found.rows["reaches"] < 0.85
    assert found.rows["above"] > 0.98
    assert found.least <= found.hold <= found.most <= 2


def test_fifty_of_fifty_can_fail_in_a_fresh_study_and_none_of_fifty_can_succeed():
    evidence, random = study(1.0, 0.0), np.random.default_rng(1)
    drawn = [evidence.fresh(random) for _ in range(400)]
    lost = np.mean([50 - fresh.sample(ONE).successes for fresh in drawn])
    won = np.mean([fresh.sample(OTHER).successes for fresh in drawn])
    assert lost == pytest.approx(50 * 0.5 / 51, abs=0.12)
    assert won == pytest.approx(50 * 0.5 / 51, abs=0.12)


def test_pairs_stay_pairs_in_a_fresh_study_also_where_one_condition_has_more_attempts():
    first, second = (rows(c, Made(n=n, rate=r)) for c, n, r in ((ONE, 50, 0.6), (OTHER, 100, 0.3)))
    evidence, random = Evidence.from_rows([*first, *second], [ONE, OTHER]), np.random.default_rng(2)
    for _ in range(20):
        fresh = evidence.fresh(random)
        _, only, other, _ = pairs(fresh.sample(ONE), fresh.sample(OTHER))
        assert only + other < 25 + 3


def test_a_pooled_sample_is_smoothed_once_not_once_a_condition():
    many = [Sample.of(rows(ONE, Made(n=20))) for _ in range(30)]
    evidence = Evidence({str(k): sample for k, sample in enumerate(many)}, {str(k): "rbo_hand2" for k in range(30)})
    random = np.random.default_rng(3)
    lost = [600 - evidence.fresh(random).grasps_with("rbo_hand2").successes for _ in range(200)]
    assert np.mean(lost) < 1.0


def test_the_draws_are_the_same_each_time():
    assert repeated(0.96, 0.5, 0.5, draws=20) == repeated(0.96, 0.5, 0.5, draws=20)
