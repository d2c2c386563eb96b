"""What the page of a study says of orders: picks an hour, attempts an order, and what went wrong."""

import json
import math

import pytest

from pilegrasp_ctrl import cli
from pilegrasp_ctrl.statistics import ratio_interval
from pilegrasp_ctrl.viewer.study.orders import orders_of
from pilegrasp_ctrl.viewer.study.page import index_page
from pilegrasp_ctrl.viewer.study.picks import MAX_DELIVERED, MISSED, UNFELT, picks_of
from pilegrasp_ctrl.viewer.study.rows import read_attempts
from synthetic_study import write_study

EMPTY = {"held": 0, "delivered": 0, "reason": "nothing was in the hand after the lift"}
ONE = {"held": 1, "delivered": 1, "reason": "", "believed_held": 1, "believed_delivered": 1}


def order(seed, attempts, success=True, time=60.0, condition="blind"):
    result = {"success": success, "grasped": 2, "reason": "", "outcomes": [], "sim_time": time, "attempts": attempts}
    return ("aaaa", seed, json.dumps({"scenario": condition}), json.dumps(result), None)


def study(tmp_path, *orders):
    return read_attempts(write_study(tmp_path, list(orders)))


def test_picks_and_attempts_have_intervals(tmp_path):
    rows = study(tmp_path, order(0, [ONE, ONE]), order(1, [EMPTY, ONE, EMPTY, ONE], time=120.0), order(2, [ONE] * 2))
    (found,) = orders_of(rows)
    assert (found.n, found.completed, found.tries) == (3, 3, 8)
    assert found.attempts[0] == pytest.approx(8 / 3)
    assert found.picks_an_hour[0] == pytest.approx(3600.0 * 6 / 240.0)
    for value, low, high in (found.attempts, found.picks_an_hour):
        assert 0.0 <= low < value < high < math.inf
    assert found.wrong == (("nothing was in the hand after the lift", 2),)


def test_what_goes_wrong_is_told_by_the_truth(tmp_path):
    missed = ONE | {"delivered": 0}
    unfelt = EMPTY | {"held": 1, "believed_held": 0}
    miscounted = ONE | {"believed_delivered": 2}
    (found,) = orders_of(study(tmp_path, order(0, [missed, unfelt, miscounted, ONE], success=False)))
    assert found.attempts is None
    assert dict(found.wrong) == {MISSED: 1, UNFELT: 1, "… counted where … were delivered": 1}
    assert found.picks_an_hour == (pytest.approx(120.0), 0.0, math.inf)


def test_the_page_and_the_json_answer_whether_it_will_pick(tmp_path, capsys):
    write_study(tmp_path, [order(0, [ONE, EMPTY, ONE])])
    assert cli.main(["report", str(tmp_path), "--json"]) == 0
    (found,) = json.loads(capsys.readouterr().out)["orders"]
    assert found["picks_an_hour"] == {"value": pytest.approx(120.0), "low": 0.0, "high": None}
    assert found["wrong"] == [{"reason": "nothing was in the hand after the lift", "attempts": 1}]
    page = (tmp_path / "index.html").read_text()
    for words in ("Will it pick?", "picks an hour", "attempts an order", "What will go wrong", "the order is complete"):
        assert words in page


def test_a_study_without_orders_has_no_such_section(tmp_path):
    rows = read_attempts(write_study(tmp_path))
    assert orders_of(rows) == []
    assert "Will it pick?" not in index_page("study", rows)


def test_nothing_in_a_result_breaks_the_count():
    assert picks_of(None) == picks_of({"attempts": 5}) == ()
    odd = picks_of({"attempts": [None, {"delivered": 1e300, "reason": ["x"]}, {"delivered": -3, "held": "many"}, []]})
    assert [pick.delivered for pick in odd] == [0, MAX_DELIVERED, 0, 0]
    assert len(picks_of({"attempts": [ONE] * 100_000})) == 500


def test_the_interval_of_a_ratio_holds_it():
    import numpy as np

    random = np.random.default_rng(0)
    inside = 0
    for _ in range(300):
        bottoms = random.uniform(40.0, 80.0, 20)
        tops = bottoms * random.uniform(0.0, 0.2, 20)
        _, low, high = ratio_interval(tops.tolist(), bottoms.tolist())
        inside += low < 0.1 < high
    assert 270 <= inside <= 299
    assert ratio_interval([], []) is None
    assert ratio_interval([1.0], [0.0]) is None
