"""The search over gains: its store, its errors, its result and its page."""

import csv
import io
import json
import os
import re
import signal
import sqlite3
import sys
import time
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

from made_up_search import BAD, made_up, search, table
from pilegrasp_ctrl import cli
from pilegrasp_ctrl.cli.study_options import search_progress
from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.episode import run
from pilegrasp_ctrl.exceptions import ConfigurationError, ExportError, SimulationError
from pilegrasp_ctrl.files import locked
from pilegrasp_ctrl.tasks.gains import MotionGains
from pilegrasp_ctrl.tuning.choice import choose
from pilegrasp_ctrl.tuning.gain_space import GainSpace, gains_table, gains_text
from pilegrasp_ctrl.tuning.search import check_seeds, run_search
from pilegrasp_ctrl.tuning.trial import TrialReport, TrialWork, run_trial

TRIALS = 12
"""Trials of a search [-]: the first ones are drawn at random, the others follow from them."""

SOFT = MotionGains(stiffness=25.0, damping_ratio=0.7)


# The store of a search


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A search that was left alone, for others to be compared with."""
    return table(run_search(search(tmp_path_factory.mktemp("whole")), TRIALS, function=made_up))


@pytest.mark.slow
def test_a_search_finds_much_better_gains_than_a_bad_start(whole):
    tracking = [row[-1].tracking for row in whole]
    assert whole[0][1:4] == (25.0, 25.0, 0.3)
    assert min(tracking) < tracking[0] / 5.0


@pytest.mark.slow
def test_the_same_command_again_does_nothing_and_more_trials_do_only_the_rest(tmp_path, whole):
    calls = []

    def counted(task):
        calls.append(task.number)
        return made_up(task)

    run_search(search(tmp_path), 8, function=counted)
    run_search(search(tmp_path), 8, function=counted)
    assert sorted(calls) == list(range(8))
    store = run_search(search(tmp_path), TRIALS, function=counted)
    assert sorted(calls) == list(range(TRIALS))
    assert table(store) == whole


@pytest.mark.slow
@pytest.mark.parametrize("last", [0, 1, 8])
def test_an_interrupt_loses_no_finished_trial_and_changes_nothing(tmp_path, whole, last):
    calls = []

    def interrupted(task):
        if len(calls) > last:
            raise KeyboardInterrupt
        calls.append(task.number)
        return made_up(task)

    with pytest.raises(KeyboardInterrupt):
        run_search(search(tmp_path), TRIALS, function=interrupted)
    again = []

    def rest(task):
        again.append(task.number)
        return made_up(task)

    assert table(run_search(search(tmp_path), TRIALS, function=rest)) == whole
    assert sorted(calls + again) == list(range(TRIALS))


def dies(work: TrialWork, times: int) -> TrialReport:
    """Kill the worker of trial 2 so many times."""
    begun = Path(work.scenario.controller.gains).with_suffix(".begun")
    count = begun.stat().st_size if begun.exists() else 0
    if work.number == 2 and count < times:
        begun.write_bytes(b"x" * (count + 1))
        os.kill(os.getpid(), signal.SIGKILL)
    return made_up(work)


@pytest.mark.slow
def test_workers_find_what_one_process_finds_even_if_one_is_killed(tmp_path, whole):
    assert table(run_search(search(tmp_path), TRIALS, jobs=2, function=partial(dies, times=1))) == whole


@pytest.mark.slow
def test_a_trial_that_kills_its_worker_again_and_again_ends_the_search_and_keeps_the_finished_ones(tmp_path, whole):
    with pytest.raises(SimulationError, match=r"3 worker processes died with trial 2.*fewer --jobs"):
        run_search(search(tmp_path), TRIALS, jobs=2, function=partial(dies, times=3))
    assert table(run_search(search(tmp_path), TRIALS, function=made_up)) == whole


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"seeds": (0, 1)}, "seeds"),
        ({"late": 1}, "late"),
        ({"scenario": load_scenario("push_wall", {"controller.kind": "operational_space"})}, "scenario.name"),
        ({"space": GainSpace.around(MotionGains(30.0), 500.0)}, "start.motion.stiffness"),
    ],
)
def test_the_store_of_another_search_is_refused(tmp_path, changes, key):
    run_search(search(tmp_path), 1, function=made_up)
    with pytest.raises(ConfigurationError, match=rf"holds another search: {key}.*choose another --out"):
        run_search(search(tmp_path, **changes), 1, function=made_up)


def test_a_search_of_another_python_is_refused(tmp_path, monkeypatch):
    run_search(search(tmp_path), 1, function=made_up)
    monkeypatch.setattr("platform.python_version_tuple", lambda: ("3", "99", "1"))
    with pytest.raises(ConfigurationError, match=r'holds another search: origins\.Python = "3.1\d" there, and "3\.99"'):
        run_search(search(tmp_path), 1, function=made_up)


def test_a_file_that_is_not_a_store_is_left_alone(tmp_path):
    (tmp_path / "tuning.db").write_text("my notes")
    with pytest.raises(ExportError, match="is not the store of a search"):
        run_search(search(tmp_path), 1, function=made_up)
    assert (tmp_path / "tuning.db").read_text() == "my notes"


def test_two_searches_do_not_write_to_one_folder(tmp_path):
    with locked(tmp_path, "search"), pytest.raises(ConfigurationError, match="another search writes there"):
        run_search(search(tmp_path), 1, function=made_up)


def test_a_failed_trial_is_kept_with_its_reason_and_never_chosen(tmp_path):
    def fails(task):
        report = made_up(task)
        return replace(report, measured=None, ringing=(), reason="the arm fell") if task.number % 2 else report

    store = run_search(search(tmp_path), 12, function=fails)
    failed = [record for record in store.records() if record.report.measured is None]
    assert [record.number for record in failed] == [1, 3, 5, 7, 9, 11]
    assert {record.report.reason for record in failed} == {"the arm fell"}
    assert choose(store.records(), 17.0)[0].number % 2 == 0
    with sqlite3.connect(tmp_path / "tuning.db") as database:
        states = database.execute("SELECT state, COUNT(*) FROM trials GROUP BY state").fetchall()
    assert dict(states) == {"COMPLETE": 6, "PRUNED": 6}


@pytest.mark.parametrize(("trials", "jobs"), [(0, 1), (1, 0)])
def test_no_trials_and_no_jobs_are_refused(tmp_path, trials, jobs):
    with pytest.raises(ConfigurationError, match="at least 1"):
        run_search(search(tmp_path), trials, jobs, function=made_up)


# Seeds


def test_seeds_for_judging_are_refused():
    check_seeds((0, 9999))
    with pytest.raises(ConfigurationError, match="seed 10000 is kept for judging"):
        check_seeds((9999, 10000))


@pytest.mark.parametrize(
    ("seeds", "words"), [("9999:10001", "kept for judging"), ("3:3", "FIRST:LAST"), ("-1:2", "FIRST:LAST")]
)
def test_the_command_refuses_seeds_in_one_sentence(tmp_path, capsys, seeds, words):
    assert cli.main(["tune", "free_space_line", f"--seeds={seeds}", "--out", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_gains_of_the_other_controller_are_refused(tmp_path, capsys):
    start = tmp_path / "start.toml"
    start.write_text(gains_text(BAD))
    command = ["tune", "free_space_line", "--controller", "impedance", "--start", str(start)]
    assert cli.main([*command, "--out", str(tmp_path / "out")]) == 2
    assert "holds MotionGains, but the controller is 'impedance'" in capsys.readouterr().err


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_the_bar_shows_rate_time_left_and_the_best(monkeypatch):
    monkeypatch.setattr("sys.stderr", Terminal())
    monkeypatch.setenv("COLUMNS", "140")
    with search_progress("free_space_line", "trials", Path("out")) as progress:
        for done, note in enumerate(("", "best 2.5 mm", "best 0.25 mm", "best 0.25 mm", "")):
            progress("trials", done, 6, note)
            time.sleep(0.15)
        progress("sensitivity", 0, 2)
        time.sleep(0.15)
        shown = sys.stderr.getvalue()
    for words in ("free_space_line: trials", "4/6", "best 2.5 mm", "best 0.25 mm", "/min", "0:00:0", "sensitivity"):
        assert words in shown


# The real thing, small

SHORT = ["--set", "line.displacement=[0.0, 0.02, 0.0]", "--set", "line.speed=0.2"]


@pytest.fixture(scope="module")
def tuned(tmp_path_factory):
    """Three trials of a line of 2 cm, through the command line, twice."""
    folder = tmp_path_factory.mktemp("tuned")
    out, start = folder / "out", folder / "start.toml"
    start.write_text(gains_text(SOFT))
    command = ["tune", "free_space_line", *SHORT, "--controller", "operational_space", "--start", str(start)]
    command += ["--trials", "3", "--out", str(out)]
    assert cli.main(command) == 0
    return out, command


@pytest.mark.slow
def test_a_real_search_leaves_gains_table_page_and_json(tuned, capsys):
    out, command = tuned
    before = (out / "trials.csv").read_bytes()
    assert cli.main([*command, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert (out / "trials.csv").read_bytes() == before
    assert document["trials"]["finished"] == 3
    assert document["start"]["gains"] == gains_table(SOFT)
    assert document["improvement"]["tracking"] >= 1.0
    assert document["best"]["margin"]["factor"] > 2.0
    rows = list(csv.DictReader((out / "trials.csv").open()))
    assert [row["trial"] for row in rows] == ["0", "1", "2"]
    assert rows[0]["translation"] == "25.0"
    assert all((out / row["gains"]).is_file() for row in rows)


@pytest.mark.slow
def test_the_best_gains_run(tuned):
    out, _ = tuned
    scenario = {"controller.kind": "operational_space", "controller.gains": str(out / "best.toml")}
    scenario |= {"line.displacement": [0.0, 0.02, 0.0], "line.speed": 0.2}
    assert run("free_space_line", overrides=scenario).success


def test_the_page_loads_nothing_from_elsewhere(tuned):
    page = (tuned[0] / "index.html").read_text(encoding="utf-8")
    assert "://" not in page
    assert "<script" not in page
    assert "<img" not in page
    assert set(re.findall(r'(?:src|href)="(.)', page)) <= {"#", "d"}
    assert set(re.findall(r'(?:src|href)="(d[^"]*)', page)) == {"data:,"}
    assert page.count("<svg") == 2 + 6 + 1
    assert "var(--best)" in page
    assert not re.findall(r"#0102\d\d", page)
    assert "pilegrasp tune free_space_line" in page


def test_gains_that_miss_the_goal_are_a_failed_trial(tmp_path):
    gains = tmp_path / "gains.toml"
    gains.write_text(gains_text(MotionGains([25.0] * 3 + [10000.0] * 3)))
    keys = {"controller.kind": "operational_space", "controller.gains": str(gains), "line.speed": 0.3}
    report = run_trial(TrialWork(3, load_scenario("free_space_line", keys), (0,)))
    assert report.measured is None
    assert not report.feasible
    assert re.match(r"seed 0: line: the line ended \d+ mm away", report.reason)
