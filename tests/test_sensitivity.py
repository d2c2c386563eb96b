"""The sensitivity run: which conditions, counted how, and never an attempt twice."""

from pathlib import Path

import pytest

from pilegrasp_ctrl.config import dotted_keys, load_scenario
from pilegrasp_ctrl.exceptions import PileError
from pilegrasp_ctrl.experiments.hand import sensitivity
from pilegrasp_ctrl.experiments.hand.figures import sensitivity_figure
from pilegrasp_ctrl.experiments.hand.sensitivity import Condition, conditions, markdown, measure, rows


class Pool:
    """Runs at once, in this process."""

    def __init__(self, *_):
        pass

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    map = staticmethod(map)


@pytest.fixture
def attempted(monkeypatch):
    tried = []

    def attempt(condition, seed):
        tried.append((condition, seed))
        return (condition.value < 1.0 or seed > 0), "lost, by chance"

    monkeypatch.setattr(sensitivity, "ProcessPoolExecutor", Pool)
    monkeypatch.setattr(sensitivity, "attempt", attempt)
    return tried


def test_every_uncertain_number_goes_down_and_up_by_the_share():
    nominal, stiffened, *varied = conditions()
    assert nominal.overrides() == {}
    assert stiffened.key == "hand_model.inflation_stiffness"
    assert {c.key for c in varied} <= set(dotted_keys())
    assert len(varied) >= 10
    for key in {c.key for c in varied}:
        assert [c.value for c in varied if c.key == key] == [0.7, 1.3]
    hashes = {load_scenario("spheres_wall", c.overrides()).config_hash() for c in conditions()}
    assert len(hashes) == len(conditions())


def test_a_run_goes_on_where_it_was_stopped(tmp_path, attempted):
    file, wanted = tmp_path / "sensitivity.csv", conditions()[:3]
    stopped = measure(wanted, range(3), 1, file)
    for _ in range(4):
        next(stopped)
    stopped.close()
    finished = len(file.read_text(encoding="utf-8").splitlines())
    attempted.clear()
    list(measure(wanted, range(3), 1, file))
    assert len(attempted) == 9 - finished
    assert [row.attempts for row in rows(file)] == [3, 3, 3]
    attempted.clear()
    assert list(measure(wanted, range(3), 1, file)) == []
    assert attempted == []


def test_successes_are_counted_with_their_interval(tmp_path, attempted):
    file, wanted = tmp_path / "sensitivity.csv", [Condition("hand_model.friction", 1.3), Condition("", 1.0)]
    list(measure(wanted, range(20), 1, file))
    nominal, friction = rows(file)
    assert (nominal.condition, nominal.successes, nominal.attempts) == (wanted[1], 19, 20)
    assert friction.interval == pytest.approx((0.764, 0.991), abs=1e-3)  # Wilson 1927, 19 of 20
    assert "| `hand_model.friction` = 1.3 | 19 of 20 | 76% to 99% |" in markdown([friction])
    sensitivity_figure([nominal, friction], tmp_path / "figure.png")
    assert (tmp_path / "figure.png").read_bytes().startswith(b"\x89PNG")


def test_an_attempt_that_cannot_be_carried_out_holds_nothing(monkeypatch):
    def fail(*_, **__):
        raise PileError("does not settle")

    monkeypatch.setattr(sensitivity, "run", fail)
    assert sensitivity.attempt(conditions()[0], 0) == (False, "does not settle")


def test_the_page_shows_what_its_attempts_say():
    docs = Path(__file__).parents[1] / "docs"
    assert markdown(rows(docs / "sensitivity.csv")) in (docs / "sensitivity.md").read_text(encoding="utf-8")
