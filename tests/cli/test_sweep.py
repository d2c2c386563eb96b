"""`pilegrasp sweep` and the tables of a study: options, output and errors."""

import csv
import io
import json
import sqlite3
import sys

import pytest

from command_line import answer
from pilegrasp_ctrl.cli.study_options import describe_progress, parse_seeds, parse_vary
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.study import run
from pilegrasp_ctrl.study.attempt import AttemptReport
from pilegrasp_ctrl.study.condition import conditions
from pilegrasp_ctrl.study.dispatch import InlinePool
from pilegrasp_ctrl.study.run import StudyProgress
from pilegrasp_ctrl.study.store import StudyStore
from pilegrasp_ctrl.study.table import table
from study_tasks import short_attempt

SWEEP = ("sweep", "spheres_wall", "--vary", "pile.count=3,5", "--set", "hand=shovel", "--seeds", "0:4", "--out")


def report(item):
    """Report an attempt that never ran; every fourth seed raises."""
    if item.seed % 4 == 3:
        return AttemptReport(item.config_hash, item.seed, None, "the pile did not come to rest")
    return short_attempt(item)


@pytest.fixture
def begun(monkeypatch):
    """The attempts that were run: count and seed."""
    run_so_far = []

    def run_work_item(item):
        run_so_far.append((item.scenario.pile.count, item.seed))
        return report(item)

    monkeypatch.setattr(run, "run_work_item", run_work_item)
    monkeypatch.setattr(run, "open_pool", lambda jobs, scheduler: InlinePool())
    return run_so_far


def test_json_is_a_row_for_each_combination(capsys, begun, tmp_path):
    status, out, err = answer(capsys, *SWEEP, tmp_path, "--json")
    assert (status, err) == (0, "")
    rows = json.loads(out)
    assert [row["condition"] for row in rows] == [
        {"scenario": "spheres_wall", "pile.count": 3},
        {"scenario": "spheres_wall", "pile.count": 5},
    ]
    keys = ["condition", "n", "successes", "rate", "ci_low", "ci_high", "multiple", "triggered", "errors"]
    assert list(rows[0]) == keys
    assert [rows[0][key] for key in ("n", "successes", "rate", "multiple", "errors")] == [4, 2, 0.5, 1, 1]
    assert rows[0]["ci_low"] == pytest.approx(0.15, abs=0.01)


def test_a_second_sweep_runs_only_the_missing_attempts(capsys, begun, tmp_path):
    answer(capsys, *SWEEP, tmp_path)
    del begun[:]
    assert answer(capsys, *SWEEP, tmp_path)[0] == 0
    assert begun == []
    more = ("sweep", "spheres_wall", "--set", "hand=shovel", "--vary", "pile.count=5,8", "--seeds", "2:6")
    status, out, _ = answer(capsys, *more, "--out", tmp_path, "--json")
    assert status == 0
    assert begun == [(5, 4), (5, 5), (8, 2), (8, 3), (8, 4), (8, 5)]
    # The output covers the attempts of this command only.
    assert [row["n"] for row in json.loads(out)] == [4, 4]


def test_the_table_names_varied_keys_and_raised_errors(capsys, begun, tmp_path):
    status, out, err = answer(capsys, *SWEEP, tmp_path)
    lines = out.splitlines()
    assert status == 0
    assert lines[0].split() == [
        *("pile.count", "attempts", "successes", "rate", "95", "%", "interval", "several", "F_grasp", "errors"),
    ]
    assert lines[1].split() == ["3", "4", "2", "50", "%", "15", "to", "85", "%", "1", "0", "1"]
    assert lines[-1] == f"every attempt is in {tmp_path / 'study.db'}"
    assert err == "seed 3 and 1 more: the pile did not come to rest\n"


def test_without_anything_varied_the_row_is_the_scenario(capsys, begun, tmp_path):
    _, out, _ = answer(capsys, "sweep", "spheres_wall", "--seeds", "7", "--out", tmp_path)
    assert out.splitlines()[1].split()[:2] == ["spheres_wall", "1"]


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        (("--set", "pile.mass=0.18"), "set.pile.mass = absent there, and 0.18 is asked for"),
        (("--vary", "pile.scale=1.0,1.1"), 'varied = ["pile.count"] there'),
    ],
)
def test_another_study_in_the_same_folder_is_refused(capsys, begun, tmp_path, changes, sentence):
    answer(capsys, *SWEEP, tmp_path)
    status, out, err = answer(capsys, *SWEEP, tmp_path, *changes)
    assert (status, out) == (2, "")
    assert f"{tmp_path / 'study.db'} holds another study: {sentence}" in err
    status, _, err = answer(capsys, "sweep", "cubes_wall", *SWEEP[2:], tmp_path)
    assert status == 2
    assert "scenario.name" in err or "scenario.pile" in err


def test_a_study_of_another_version_is_refused(capsys, begun, tmp_path):
    answer(capsys, *SWEEP, tmp_path)
    with sqlite3.connect(tmp_path / "study.db") as connection:
        connection.execute("UPDATE origins SET identity = '3.9.0' WHERE name = 'mujoco'")
    status, _, err = answer(capsys, *SWEEP, tmp_path)
    assert status == 2
    assert "mujoco is 3.9.0 for " in err
    # The stored attempts can still be read.
    assert answer(capsys, "export", tmp_path, tmp_path / "table.csv")[0] == 0


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("--seeds", "5:5"), "--seeds '5:5' must be FIRST:LAST"),
        (("--seeds", "-1:5"), "must be FIRST:LAST"),
        (("--seeds", "a"), "must be FIRST:LAST"),
        (("--seeds", "0:1", "--vary", "pile.count"), "--vary 'pile.count' is not of the form key=a,b,c"),
        (("--seeds", "0:1", "--vary", "pile.count="), "is not of the form"),
        (("--seeds", "0:1", "--vary", "pile.count=1", "--vary", "pile.count=2"), "given twice"),
        (("--seeds", "0:1", "--vary", "pile.count=3,-2"), "pile.count = -2 is not allowed"),
        (("--seeds", "0:1", "--vary", "pile.cuont=3"), "unknown key 'pile.cuont'"),
        (("--seeds", "0:1", "--set", "pile.count=3", "--vary", "pile.count=3"), "is set and varied"),
        (("--seeds", "0:1", "--jobs", "2", "--scheduler", "tcp://10.0.0.1:8786"), "leave out one of the two"),
    ],
)
def test_wrong_options_are_refused_before_anything_is_made(capsys, begun, tmp_path, options, sentence):
    status, out, err = answer(capsys, "sweep", "spheres_wall", *options, "--out", tmp_path / "study")
    assert (status, out) == (2, "")
    assert sentence in err
    assert err.count("\n") == 1
    assert not (tmp_path / "study").exists()
    assert begun == []


def test_values_are_toml_or_text():
    assert parse_vary(["pile.count=3, 5", "pile.mass=0.06,0.18"]) == {"pile.count": [3, 5], "pile.mass": [0.06, 0.18]}
    assert parse_vary(["hand=rbo_hand2,shovel"]) == {"hand": ["rbo_hand2", "shovel"]}
    assert parse_vary(["line.start=[0.5,0.0,0.2],[0.6,0.0,0.2]"]) == {"line.start": [[0.5, 0.0, 0.2], [0.6, 0.0, 0.2]]}
    assert parse_vary(["controller.compiled=true,false"]) == {"controller.compiled": [True, False]}
    assert parse_seeds("10000:10050") == range(10000, 10050)
    with pytest.raises(ConfigurationError):
        parse_vary(["=3"])


def test_the_bar_shows_rate_time_left_and_success_so_far(capsys, begun, tmp_path, monkeypatch):
    assert describe_progress(StudyProgress(100, 10, 0, 9, 0, 0.0)) == "success 90%"
    assert describe_progress(StudyProgress(100, 10, 30, 38, 2, 60.0)) == "30/min, 0:02:00 left, success 95%, 2 errors"
    assert describe_progress(StudyProgress(100, 0, 0, 0, 0, 0.0)) == "first attempts"
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    status, out, _ = answer(capsys, *SWEEP, tmp_path, "--json")
    assert status == 0
    assert json.loads(out)


def test_a_csv_has_a_line_for_each_attempt(capsys, begun, tmp_path):
    answer(capsys, *SWEEP, tmp_path / "study")
    status, out, err = answer(capsys, "export", tmp_path / "study", tmp_path / "table.csv")
    assert (status, out, err) == (0, f"{tmp_path / 'table.csv'}\n", "")
    lines = list(csv.DictReader(io.StringIO((tmp_path / "table.csv").read_text())))
    assert [(line["pile.count"], line["seed"]) for line in lines] == [(c, str(s)) for c in "35" for s in range(4)]
    assert list(lines[0])[:4] == ["scenario", "config_hash", "seed", "pile.count"]
    assert (lines[1]["success"], lines[1]["grasped"], lines[1]["error"]) == ("True", "1", "")
    assert lines[3]["error"] == "the pile did not come to rest"
    document = json.loads(answer(capsys, "export", tmp_path / "study", tmp_path / "b.csv", "--json")[1])
    assert document == {"study": str(tmp_path / "study"), "csv": str(tmp_path / "b.csv"), "attempts": 8}


def test_nested_results_become_columns_and_keys_that_others_vary_are_filled_in(tmp_path):
    found = [*conditions("spheres_wall", {"pile.count": [3]}), *conditions("cubes_wall", {"hand": ["shovel"]})]
    result = {
        "success": True,
        "grasped": 1,
        "outcomes": [{"name": "push", "trigger": "grasp force", "peak_force": 17.2}],
        "measures": {"speed": {"inside": 0.03}, "field": [1, 2]},
    }
    with StudyStore(tmp_path, create=True) as store:
        store.adopt(found, {})
        store.add([(one, AttemptReport(one.config_hash, 0, json.dumps(result), None, True)) for one in found])
        first, second = table(store)
    assert (first["pile.count"], first["hand"]) == (3, "rbo_hand2")
    assert (second["pile.count"], second["hand"]) == (14, "shovel")
    assert (first["push.peak_force"], first["measures.speed.inside"]) == (17.2, 0.03)
    assert first["measures.field"] == "[1, 2]"
    assert first["triggered"] is True
    assert list(first) == list(second)


def test_parquet_keeps_the_types(capsys, begun, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    answer(capsys, *SWEEP, tmp_path / "study")
    assert answer(capsys, "export", tmp_path / "study", tmp_path / "table.parquet")[0] == 0
    read = parquet.read_table(tmp_path / "table.parquet")
    kinds = {field.name: str(field.type) for field in read.schema}
    assert {kinds[name] for name in ("scenario", "config_hash", "reason", "error")} == {"string"}
    assert (kinds["seed"], kinds["pile.count"], kinds["success"]) == ("int64", "int64", "bool")
    with StudyStore(tmp_path / "study") as store:
        assert read.to_pylist() == table(store)


def test_without_pyarrow_parquet_is_refused_with_the_remedy(capsys, begun, tmp_path, monkeypatch):
    answer(capsys, *SWEEP, tmp_path / "study")
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    status, _, err = answer(capsys, "export", tmp_path / "study", tmp_path / "table.parquet")
    assert status == 2
    assert "pip install 'pilegrasp[parquet]'" in err
    assert not (tmp_path / "table.parquet").exists()


@pytest.mark.parametrize(
    ("output", "sentence"), [("a.html", "must end in .csv or .parquet"), ("no/a.csv", "does not exist")]
)
def test_a_study_is_exported_only_as_a_table(capsys, begun, tmp_path, output, sentence):
    answer(capsys, *SWEEP, tmp_path / "study")
    status, _, err = answer(capsys, "export", tmp_path / "study", tmp_path / output)
    assert status == 2
    assert sentence in err
    status, _, err = answer(capsys, "export", tmp_path, tmp_path / "a.csv")
    assert status == 2
    assert "no such study" in err
