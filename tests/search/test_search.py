"""The search over strategies on landscapes whose optimum is known, without an attempt."""

import numpy as np
import pytest

from pilegrasp_ctrl.search.ablation import MARGIN, ablate, changes
from pilegrasp_ctrl.search.choice import choose, tied
from pilegrasp_ctrl.search.evidence import lead_interval, log_evidence, mean_interval
from pilegrasp_ctrl.search.judgement import judge, verdict_of
from pilegrasp_ctrl.search.race import ERROR, FIRST, Candidate, Race
from pilegrasp_ctrl.search.samples import OBJECTIVES, Samples
from pilegrasp_ctrl.search.space import Choice, Range, Space

SPACE = Space(
    (Range("alpha", -60.0, 60.0), Range("force", 8.0, 40.0), Choice("hand", ("a", "b"))),
    {"alpha": 0.0, "force": 17.0, "hand": "a"},
)
BEST = 0.96


def rate(values):
    """Rate of a landscape with its optimum at 25 degrees, 12 N and hand b."""
    loss = 1.2 * ((values["alpha"] - 25.0) / 60.0) ** 2 + 0.8 * ((values["force"] - 12.0) / 20.0) ** 2
    return max(0.05, BEST - loss - 0.2 * (values["hand"] == "a"))


def samples(score, time=15.0, peak=20.0):
    score = np.asarray(score, dtype=float)
    score = score[:, None] if score.ndim == 1 else score
    return Samples(score, np.broadcast_to(np.asarray(time, float), score.shape).copy(), np.full(score.shape, peak))


def luck(run, number, n):
    """Half of the luck belongs to the seed, which all candidates share."""
    common = np.random.default_rng([run, 999_999]).random((2, 5000))
    own = np.random.default_rng([run, number]).random(5000)
    return np.where(common[0] < 0.5, common[1], own)[:n]


def raced(run, budget, rates=rate, space=SPACE):
    def measure(wanted):
        for candidate, n in wanted:
            candidate.samples = samples(luck(run, candidate.number, n) < rates(candidate.values))

    race = Race(space, OBJECTIVES["held"], budget)
    race.run(measure)
    return race


def test_the_winner_is_right_in_18_of_20_searches():
    found = []
    for run in range(20):
        race = raced(run, 1000)
        found.append(rate(choose(race, tied(race)).values) >= BEST - 0.05)
        assert race.spent <= 1000
    assert sum(found) >= 18


def test_a_search_repeated_takes_the_same_steps():
    one, other = raced(3, 300), raced(3, 300)
    assert [(each.values, each.n) for each in one.candidates] == [(each.values, each.n) for each in other.candidates]


def test_a_larger_budget_begins_with_the_same_candidates():
    small, large = (raced(3, budget).candidates for budget in (200, 400))
    assert [each.values for each in small[:4]] == [each.values for each in large[:4]]


def test_a_small_budget_tries_a_search_out():
    race = raced(0, 8)
    assert (len(race.candidates), race.spent, race.first) == (4, 8, 2)
    assert raced(0, 300).first == FIRST


def test_a_small_space_is_listed_and_all_but_the_best_leave_the_race():
    space = Space((Choice("hand", ("a", "b", "c")),), {"hand": "a"})
    race = raced(0, 2000, lambda values: {"a": 0.3, "b": 0.95, "c": 0.4}[values["hand"]], space)
    assert [each.values["hand"] for each in race.candidates] == ["a", "b", "c"]
    assert [each.values["hand"] for each in race.alive] == ["b"]
    assert race.spent < 300


def test_the_best_of_equals_is_hardly_ever_eliminated_although_the_race_looks_all_the_time():
    random = np.random.default_rng(1)
    exceeded = 0
    for _ in range(200):
        lead = random.integers(0, 2, 300) - random.integers(0, 2, 300)
        exceeded += any(log_evidence(lead[:n]) >= np.log(1.0 / ERROR) for n in range(5, 300, 5))
    assert exceeded <= 200 * ERROR


def test_the_capital_of_wins_alone_is_that_of_robbins():
    # 2^n / (n + 1) for n wins: the mixture over all chances above one half has twice that without its lower half.
    assert log_evidence(np.ones(20)) == pytest.approx(np.log((2.0**21 - 1.0) / 21.0), abs=0.05)


def test_an_interval_valid_at_all_times_holds_the_mean_and_shrinks():
    random = np.random.default_rng(2)
    values = (random.random(800) < 0.9).astype(float)
    low, high = mean_interval(values, 0.05)
    wide_low, wide_high = mean_interval(values[:50], 0.05)
    assert low < 0.9 < high
    assert high - low < 0.1 < wide_high - wide_low
    assert mean_interval(np.zeros(0), 0.05) == pytest.approx((0.0, 1.0), abs=1e-3)
    assert mean_interval(np.ones(100), 0.05)[1] == 1.0
    low, high = lead_interval(values[:400] - values[400:], 0.05)
    assert low < 0.0 < high


def test_evidence_begins_after_the_seeds_of_the_proposals():
    race = Race(SPACE, OBJECTIVES["held"], 1000)
    one, other = Candidate(0, {}, samples(np.ones(FIRST))), Candidate(1, {}, samples(np.zeros(FIRST)))
    race.candidates = [one, other]
    assert race.evidence(one, other, 0.0) == 0.0
    one.samples, other.samples = samples(np.ones(FIRST + 20)), samples(np.zeros(FIRST + 20))
    assert race.evidence(one, other, 0.0) > race.threshold


def test_the_robust_objective_is_that_of_the_worst_world():
    race = Race(SPACE, OBJECTIVES["robust"], 1000, worlds=2)
    safe = Candidate(0, {}, samples(np.ones((40, 2)) * [0.0, 0.0] + (np.arange(40) % 5 > 0)[:, None]))
    brittle = Candidate(1, {}, samples(np.stack([np.ones(40), np.zeros(40)], axis=1)))
    race.candidates = [safe, brittle]
    assert race.value(safe) == pytest.approx(0.8)
    assert race.value(brittle) == 0.0
    assert race.evidence(safe, brittle, 0.0) > race.threshold > race.evidence(brittle, safe, 0.0)


def test_picks_an_hour_count_the_whole_cycle():
    slow, fast = samples(np.ones(40), 40.0), samples((np.arange(40) % 10 > 0).astype(float), 20.0)
    assert slow.picks_an_hour == pytest.approx(90.0)
    assert fast.picks_an_hour == pytest.approx(162.0)
    race = Race(SPACE, OBJECTIVES["picks"], 1000)
    race.candidates = [Candidate(0, {}, slow), Candidate(1, {}, fast)]
    assert race.alive[0].number == 1
    assert race.evidence(race.candidates[1], race.candidates[0], race.rate()) > race.threshold


def test_ties_are_broken_by_picks_then_force_then_distance_from_the_start():
    race = Race(SPACE, OBJECTIVES["held"], 1000)
    far, near = {"alpha": 60.0, "force": 8.0, "hand": "b"}, {"alpha": 3.0, "force": 17.0, "hand": "a"}
    score = np.ones(64)
    race.candidates = [
        Candidate(1, far, samples(score, 15.0, 20.0)),
        Candidate(2, near, samples(score, 15.3, 20.4)),
        Candidate(3, SPACE.start, samples(score, 30.0, 10.0)),
        Candidate(4, near, samples(score, 15.0, 40.0)),
        Candidate(5, near, samples(np.arange(64) % 2, 1.0, 1.0)),
    ]
    ties = tied(race)
    assert sorted(each.number for each in ties) == [1, 2, 3, 4]
    assert choose(race, ties).number == 2


def test_the_judgement_is_paired():
    start, winner = np.repeat([1, 1, 0, 0], [60, 2, 25, 13]), np.repeat([1, 0, 1, 0], [60, 2, 25, 13])
    found = judge(OBJECTIVES["held"], samples(start), samples(winner))
    assert (found.start, found.winner, found.gain) == (0.62, 0.85, pytest.approx(0.23))
    (world,) = found.worlds
    assert (world["winner_only"], world["start_only"]) == (25, 2)
    assert world["p"] < 1e-4
    assert found.verdict == "better"
    assert 0.1 < found.low < 0.23 < found.high < 0.35


@pytest.mark.parametrize(
    ("low", "high", "bound", "verdict"),
    [
        (0.01, 0.1, 0.09, "better"),
        (-0.1, -0.01, -0.02, "worse"),
        (-0.1, 0.12, 0.1, "nothing found"),
        (-0.1, 0.3, 0.25, "undecided"),
    ],
)
def test_a_verdict_needs_an_interval(low, high, bound, verdict):
    assert verdict_of(low, high, bound) == verdict


def test_the_gain_in_picks_has_an_interval_by_resampled_seeds():
    random = np.random.default_rng(3)
    start, winner = (samples(random.random(100) < 0.9, seconds) for seconds in (30.0, 20.0))
    found = judge(OBJECTIVES["picks"], start, winner)
    assert 0.3 < found.low < 0.5 < found.high < 0.7
    assert found.verdict == "better"


CHANGED = {"alpha": 25.0, "force": 12.0, "hand": "b", "speed": 0.2}


def ablated(run, rate, n=200):
    """Return the ablation of a winner with four changes, for a rate by the keys that are kept."""

    def measure(kept):
        number = 1 + sum(2**place for place, key in enumerate(CHANGED) if key in kept)
        return samples(luck(run, number, n) < rate(frozenset(kept)))

    return ablate(OBJECTIVES["held"], CHANGED, measure(CHANGED), measure)


def test_the_smallest_change_is_found_in_18_of_20_ablations():
    right = [ablated(run, lambda kept: 0.6 + 0.35 * ("force" in kept)).smallest for run in range(20)]
    assert sum(kept == {"force": 12.0} for kept in right) >= 18


def test_two_keys_that_help_only_together_are_both_kept():
    found = ablated(0, lambda kept: 0.95 if {"alpha", "hand"} <= kept else 0.4)
    assert set(found.smallest) == {"alpha", "hand"}
    assert [step.round for step in found.steps] == [1] * 4 + [2] * 3 + [3] * 2
    assert sum(step.chosen for step in found.steps) == 2
    assert all(step.suffices == (step.low > -MARGIN) for step in found.steps)


def test_a_winner_that_is_no_better_needs_no_change_and_one_that_cannot_do_without_keeps_all():
    assert ablated(1, lambda kept: 0.9).smallest == {}
    assert ablated(1, lambda kept: 0.95 - 0.3 * (4 - len(kept))).smallest == CHANGED
    assert ablate(OBJECTIVES["held"], {}, samples(np.ones(9)), lambda kept: None).smallest == {}
    alone = ablate(OBJECTIVES["held"], {"force": 12.0}, samples(np.ones(99)), lambda kept: None)
    assert (alone.smallest, alone.steps[0].value) == ({"force": 12.0}, None)


def test_only_what_differs_from_the_start_is_a_change():
    assert changes({"a": 1.0, "b": None}, {"a": 1.0, "b": 2.0}) == {"b": 2.0}


def test_few_seeds_decide_nothing():
    for objective in ("held", "picks"):
        found = judge(OBJECTIVES[objective], samples([0, 0]), samples([1, 1], 10.0))
        assert found.verdict == "undecided"
