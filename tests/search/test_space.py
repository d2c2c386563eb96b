"""What `--over` takes, and what a search refuses."""

import pytest

from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.search.run import plan_search
from pilegrasp_ctrl.search.space import Choice, Range, Space, parse_over


def test_ranges_and_choices_are_read():
    one, other = parse_over(["strategy.speed=0.05:0.4", "hand=rbo_hand2,shovel"])
    assert one == Range("strategy.speed", 0.05, 0.4)
    assert other == Choice("hand", ("rbo_hand2", "shovel"))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("strategy.speed", "is not of the form"),
        ("=1:2", "is not of the form"),
        ("strategy.speed=", "is not of the form"),
        ("strategy.speed=0.4:0.05", "from a smaller to a larger"),
        ("strategy.speed=0.1:0.1", "from a smaller to a larger"),
        ("strategy.speed=nan:0.4", "finite"),
        ("strategy.speed=0.1:inf", "finite"),
        ("pile.count=1:" + "9" * 30, "finite"),
        ("strategy.speed=0.1", "at least two values"),
        ("strategy.speed=a:b", "at least two values"),
        ("strategy.speed=0.1,0.1", "given twice"),
        ("pile.count=" + ",".join(map(str, range(101))), "100 are allowed"),
    ],
)
def test_a_text_that_is_no_range_is_refused_in_a_sentence(text, words):
    with pytest.raises(ConfigurationError, match=words):
        parse_over([text])


def test_keys_are_limited_and_named_once():
    with pytest.raises(ConfigurationError, match="--over is missing"):
        parse_over([])
    with pytest.raises(ConfigurationError, match="given twice"):
        parse_over(["pile.count=1:3", "pile.count=1:4"])
    with pytest.raises(ConfigurationError, match="20 are allowed"):
        parse_over([f"a{k}=1:2" for k in range(21)])


@pytest.mark.parametrize(
    ("over", "options", "words"),
    [
        ("strategy.sped=0.05:0.4", {}, "strategy.speed"),
        ("strategy.speed=0.05:4", {}, "strategy.speed = 4"),
        ("pile.count=1.5:3", {}, "pile.count"),
        ("summary=a,b", {}, "mean the same"),
        ("strategy.speed=0.05:0.4", {"overrides": {"strategy.speed": 0.1}}, "is set and searched over"),
        ("strategy.speed=0.05:0.4", {"objective": "most"}, "--objective 'most'"),
        ("strategy.speed=0.05:0.4", {"objective": "robust"}, "belong together"),
        ("strategy.speed=0.05:0.4", {"vary": {"pile.count": [1, 2]}}, "belong together"),
        ("strategy.speed=0.05:0.4", {"vary": {"strategy.speed": [1, 2]}, "objective": "robust"}, "in --over and"),
        ("strategy.speed=0.05:0.4", {"budget": 7}, "--budget 7 must be from 8"),
        ("strategy.speed=0.05:0.4", {"budget": 10**9}, "--budget"),
        ("strategy.speed=0.05:0.4", {"seeds": range(9000, 10_001)}, "kept for judging"),
        ("strategy.speed=0.05:0.4", {"seeds": range(3)}, "at least 8 seeds"),
        ("strategy.speed=0.05:0.4", {"judging": range(999, 1100)}, "must not share"),
    ],
)
def test_a_search_that_makes_no_sense_is_refused_in_a_sentence(over, options, words, tmp_path):
    with pytest.raises(ConfigurationError, match=words):
        plan_search("spheres_wall", parse_over([over]), tmp_path / "out", **options)
    assert not (tmp_path / "out").exists()


def test_a_search_without_a_pile_is_refused(tmp_path):
    with pytest.raises(ConfigurationError, match="needs a scenario with a pile"):
        plan_search("free_space_line", parse_over(["line.speed=0.1:0.3"]), tmp_path)


def test_values_are_short_and_stay_within_the_range():
    speed, count = Range("speed", 0.05, 0.4), Range("count", 2, 4, whole=True)
    for share in (0.0, 0.123456, 0.5, 0.999, 1.0):
        assert 0.05 <= speed.value(share) <= 0.4
        assert len(str(speed.value(share))) <= 8
        assert count.value(share) in (2, 3, 4)
    assert count.size == 3
    assert {count.value(count.share(value)) for value in (2, 3, 4)} == {2, 3, 4}


def test_a_whole_key_takes_whole_numbers_alone():
    space = Space.around("spheres_wall", parse_over(["pile.count=3:9", "strategy.speed=0.1:0.2"]), {})
    assert [each.whole for each in space.parameters] == [True, False]
    assert space.start == {"pile.count": 18, "strategy.speed": 0.1}
    assert space.distance({"pile.count": 18, "strategy.speed": 0.15}) == pytest.approx(0.5)
