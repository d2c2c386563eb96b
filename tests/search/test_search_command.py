"""`pilegrasp search` on a study whose attempts are made up, and its refusals."""

import json
import tomllib

import numpy as np
import pytest

from command_line import answer, one_sentence
from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.study import run as study_run
from pilegrasp_ctrl.study.attempt import AttemptReport
from pilegrasp_ctrl.study.dispatch import InlinePool

OVER = ("--over", "strategy.alpha_deg=-30:30", "--over", "strategy.grasp_force=8,17,30")
COMMAND = (
    "search",
    "spheres_wall",
    *OVER,
    "--budget",
    "160",
    "--seeds",
    "0:100",
    "--judge",
    "30000:30040",
    "--jobs",
    "1",
)


def made_up(item):
    """An attempt that succeeds the more surely the nearer it is to 20 degrees and 8 N; a force of 30 N raises."""
    strategy = item.scenario.strategy
    if strategy.grasp_force == 30.0:
        return AttemptReport(item.config_hash, item.seed, None, "a pose is out of reach")
    rate = 0.95 - ((strategy.alpha_deg - 20.0) / 60.0) ** 2 - 0.3 * (strategy.grasp_force > 10.0)
    success = bool(np.random.default_rng(item.seed).random() < rate)
    push = {"name": "push", "trigger": "grasp force", "peak_force": strategy.grasp_force}
    result = {"success": success, "grasped": int(success), "outcomes": [push], "sim_time": 12.0}
    return AttemptReport(item.config_hash, item.seed, json.dumps(result), None, success)


@pytest.fixture
def without_attempts(monkeypatch):
    done = []
    monkeypatch.setattr(study_run, "run_work_item", lambda item: done.append(item) or made_up(item))
    monkeypatch.setattr(study_run, "WorkerPool", lambda jobs: InlinePool())
    return done


def test_a_search_leaves_a_scenario_table_page_and_json_and_repeats_nothing(without_attempts, tmp_path, capsys):
    status, out, err = answer(capsys, *COMMAND, "--out", tmp_path / "found", "--json")
    assert status == 0, err
    document = json.loads(out)
    assert document["attempts"] <= 160
    assert document["judgement"]["winner"] > document["judgement"]["start"]
    assert document["verdict"] == "better"
    winner = document["winner"]["set"]
    assert winner["strategy.grasp_force"] == 8
    assert 5.0 < winner["strategy.alpha_deg"] <= 30.0
    best = load_scenario(tmp_path / "found" / "best.toml")
    assert best.config_hash() == load_scenario("spheres_wall", winner).config_hash()
    assert tomllib.loads((tmp_path / "found" / "best.toml").read_text())["strategy"]["grasp_force"] == 8
    rows = (tmp_path / "found" / "candidates.csv").read_text().splitlines()
    assert len(rows) == 1 + len(document["candidates"])
    page = (tmp_path / "found" / "index.html").read_text()
    for words in ("The search found a better strategy.", "strategy.alpha_deg", "McNemar", "What was not decided"):
        assert words in page
    assert "http" not in page.split("How to repeat")[0].replace("http-equiv", "")
    first = len(without_attempts)
    assert first == document["attempts"] + 80
    again = answer(capsys, *COMMAND, "--out", tmp_path / "found", "--json")
    assert json.loads(again[1]) == document
    assert len(without_attempts) == first


def test_an_ablation_leaves_the_smallest_change_as_a_scenario(without_attempts, tmp_path, capsys):
    command = (*COMMAND, "--over", "strategy.speed=0.05:0.4", "--out", tmp_path)
    plain = json.loads(answer(capsys, *command, "--json")[1])
    assert plain["ablation"] is None
    status, out, err = answer(capsys, *command, "--ablate", "--json")
    assert status == 0, err
    document = json.loads(out)
    assert {**document, "ablation": None, "files": 0} == {**plain, "files": 0}
    kept = document["ablation"]["smallest"]
    assert "strategy.speed" not in kept
    assert kept.items() <= document["winner"]["set"].items()
    assert load_scenario(tmp_path / "smallest.toml").config_hash() == load_scenario("spheres_wall", kept).config_hash()
    assert "What suffices" in (tmp_path / "index.html").read_text()
    count = len(without_attempts)
    assert json.loads(answer(capsys, *command, "--ablate", "--json")[1]) == document
    assert len(without_attempts) == count


def test_an_interrupt_loses_no_attempt_and_changes_nothing(without_attempts, tmp_path, capsys, monkeypatch):
    whole = json.loads(answer(capsys, *COMMAND, "--out", tmp_path / "whole", "--json")[1])
    count = len(without_attempts)

    def interrupted(item):
        if len(without_attempts) == count + 50:
            raise KeyboardInterrupt
        without_attempts.append(item)
        return made_up(item)

    with monkeypatch.context() as broken:
        broken.setattr(study_run, "run_work_item", interrupted)
        assert answer(capsys, *COMMAND, "--out", tmp_path / "part")[0] == 130
    document = json.loads(answer(capsys, *COMMAND, "--out", tmp_path / "part", "--json")[1])
    assert len(without_attempts) == 2 * count
    assert {**document, "files": 0} == {**whole, "files": 0}


def test_picks_and_worlds_are_searched_for(without_attempts, tmp_path, capsys):
    for objective in (("picks",), ("robust", "--vary", "sensor.slow_drift=0,1")):
        command = (*COMMAND[:-2], "--jobs", "1", "--objective", *objective, "--out", tmp_path / objective[0])
        status, out, err = answer(capsys, *command, "--json")
        assert status == 0, err
        document = json.loads(out)
        assert len(document["worlds"]) == len(document["judgement"]["worlds"]) == (2 if len(objective) > 1 else 1)
        assert document["winner"]["set"]["strategy.grasp_force"] == 8


@pytest.mark.parametrize("change", [("--objective", "single"), ("--set", "pile.count=5"), ("--judge", "31000:31010")])
def test_the_folder_of_another_search_is_refused(without_attempts, tmp_path, capsys, change):
    small = ("search", "spheres_wall", *OVER, "--budget", "16", "--judge", "30000:30001", "--jobs", "1")
    assert answer(capsys, *small, "--out", tmp_path)[0] == 0
    status, out, err = answer(capsys, *small, *change, "--out", tmp_path)
    assert (status, out) == (2, "")
    assert one_sentence(err)
    assert "holds another study" in err


def test_a_damaged_store_is_refused(without_attempts, tmp_path, capsys):
    (tmp_path / "study.db").write_bytes(b"SQLite format 3\0" + b"x" * 4000)
    status, out, err = answer(capsys, *COMMAND, "--out", tmp_path)
    assert (status, out) == (2, "")
    assert one_sentence(err)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--over", "strategy.speed=0.4:0.05"), "from a smaller to a larger"),
        (("--over", "strategy.sped=0.05:0.4"), "unknown key"),
        (("--over", "strategy.speed=0.05:4"), "strategy.speed"),
        (("--over", "strategy.speed=nan:0.4"), "finite"),
        ((), "--over is missing"),
        (("--over", "strategy.speed=0.05:0.4", "--budget", "9" * 30), "--budget"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(tmp_path, capsys, options, words):
    status, out, err = answer(capsys, "search", "spheres_wall", *options, "--out", tmp_path / "found")
    assert (status, out) == (2, "")
    assert one_sentence(err)
    assert words in err
    assert not (tmp_path / "found").exists()
