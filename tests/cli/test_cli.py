"""The command line: its output, its errors and its exit status."""

import json
import os
import shutil
import sys
import types
from pathlib import Path

import pytest

import pilegrasp_ctrl
from command_line import JSON_KEYS, answer, one_sentence
from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.exceptions import SimulationError
from pilegrasp_ctrl.provenance import dependencies
from pilegrasp_ctrl.scenarios import FOLDER, names
from pilegrasp_ctrl.validation import installation as doctor
from synthetic_recording import synthetic


class FakeResult:
    """An attempt that never happened."""

    def __init__(self, scenario, seed, recording, success=True):
        self.recording = recording
        self.facts = {
            "scenario": scenario.name,
            "seed": seed,
            "config_hash": scenario.config_hash(),
            "success": success,
            "grasped": 2 if success else 0,
            "reason": "" if success else "nothing was [held]",
            "outcomes": [
                {
                    "name": "push",
                    "status": "ended",
                    "trigger": "grasp_force",
                    "start": 1.5,
                    "end": 4.25,
                    "travel": 0.275,
                    "peak_force": 17.3,
                }
            ],
            "sim_time": 6.0,
            "wall_time": 1.5,
            "realtime_factor": 4.0,
            "controller": {"ticks": 3000, "median_us": 41.0, "p99_us": 95.0, "limited": 0, "fallbacks": 0},
        }

    def as_dict(self):
        return self.facts


@pytest.fixture
def attempts(monkeypatch):
    """Put a fake attempt in place of the real one, and note how it was called."""
    calls = []

    def run(scenario, *, seed=0, record=False, overrides=None, progress=None):
        scenario = load_scenario(scenario, overrides) if isinstance(scenario, str) else scenario
        calls.append({"scenario": scenario, "seed": seed, "record": record, "progress": progress})
        return FakeResult(scenario, seed, synthetic() if record else None)

    episode = types.ModuleType("pilegrasp_ctrl.episode")
    episode.run = run
    monkeypatch.setitem(sys.modules, "pilegrasp_ctrl.episode", episode)
    monkeypatch.setattr(pilegrasp_ctrl, "episode", episode, raising=False)
    return calls


def test_list_names_every_scenario(capsys):
    status, out, err = answer(capsys, "list")
    assert (status, err) == (0, "")
    assert all(name in out for name in names())


@pytest.mark.parametrize("columns", ["0", "20", "80", "wide"])
def test_a_list_that_is_not_read_in_a_terminal_has_one_line_a_scenario(capsys, monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", columns)
    lines = [line.split() for line in answer(capsys, "list")[1].splitlines()]
    assert [words[0] for words in lines] == ["scenario", *names()]
    assert all(" ".join(words).endswith(load_scenario(words[0]).summary) for words in lines[1:])


def test_a_narrow_terminal_cuts_no_name(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "20")
    monkeypatch.setenv("FORCE_COLOR", "1")
    out = answer(capsys, "list")[1]
    assert "…" not in out
    assert all(name in out for name in names())


def test_list_as_json(capsys):
    status, out, err = answer(capsys, "list", "--json")
    rows = json.loads(out)
    assert (status, err) == (0, "")
    assert [row["name"] for row in rows] == names()
    assert all(row["summary"] and isinstance(row["tags"], list) for row in rows)


def test_list_by_tag(capsys):
    rows = json.loads(answer(capsys, "list", "--tag", "paper", "--json")[1])
    assert {row["name"] for row in rows} == {
        "bin_picking",
        "spheres_wall",
        "spheres_corner",
        "spheres_alone",
        "cylinders_wall",
        "cubes_wall",
    }


def test_an_unknown_tag_is_an_error_that_names_the_tags(capsys):
    status, out, err = answer(capsys, "list", "--tag", "papper")
    assert (status, out) == (2, "")
    assert one_sentence(err)
    assert "control, corner, grasp, paper, wall" in err


def test_run_prints_a_summary(capsys, attempts):
    status, out, err = answer(capsys, "run", "spheres_wall")
    assert (status, err) == (0, "")
    assert "spheres_wall, seed 0: success; objects held: 2" in out
    assert all(
        word in out for word in ("travel [m]", "push", "grasp_force", "0.275", "17.3", "4.0x real time", "41 us")
    )
    assert attempts[0]["record"] is False


def test_run_uses_seed_and_settings(capsys, attempts):
    arguments = ["run", "spheres_wall", "--seed", 7, "--set", "pile.count=5", "--set", "pile.object=cube", "--json"]
    status, out, err = answer(capsys, *arguments)
    assert (status, err) == (0, "")
    assert json.loads(out).keys() >= JSON_KEYS
    assert json.loads(out)["seed"] == attempts[0]["seed"] == 7
    assert (attempts[0]["scenario"].pile.count, attempts[0]["scenario"].pile.object) == (5, "cube")


def test_run_takes_a_file(capsys, attempts, tmp_path):
    shutil.copy(FOLDER / "cubes_wall.toml", tmp_path / "mine.toml")
    status, out, _ = answer(capsys, "run", tmp_path / "mine.toml", "--json")
    assert status == 0
    assert json.loads(out)["scenario"] == "cubes_wall"


def test_an_attempt_that_holds_nothing_is_a_result(capsys, attempts, monkeypatch):
    fake = sys.modules["pilegrasp_ctrl.episode"]
    monkeypatch.setattr(fake, "run", lambda scenario, **_: FakeResult(scenario, 0, None, success=False))
    status, out, err = answer(capsys, "run", "spheres_wall")
    assert (status, err) == (0, "")
    assert "no success: nothing was [held]\n" in out
    assert json.loads(answer(capsys, "run", "spheres_wall", "--json")[1])["success"] is False


def test_run_writes_recording_and_page(capsys, attempts, tmp_path):
    record, html = tmp_path / "a.npz", tmp_path / "a.html"
    status, out, _ = answer(capsys, "run", "spheres_wall", "--record", record, "--html", html)
    assert status == 0
    assert attempts[0]["record"] is True
    assert f"wrote {record}" in out
    assert f"wrote {html}" in out
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.html", "a.npz"]
    assert pilegrasp_ctrl.Recording.load(record).meta["motion"]["hand_speed"] > 0.0


def test_a_page_alone_implies_a_recording(capsys, attempts, tmp_path):
    status, _, _ = answer(capsys, "run", "spheres_wall", "--html", tmp_path / "a.html")
    assert status == 0
    assert [path.name for path in tmp_path.iterdir()] == ["a.html"]


@pytest.mark.parametrize(
    ("option", "place", "words"),
    [
        ("--record", "nowhere/a.npz", "does not exist"),
        ("--html", "nowhere/a.html", "does not exist"),
        ("--record", "a.zip", "must end in .npz"),
        ("--html", "a.npz", "must end in .html"),
        ("--html", "folder.html", "is a folder"),
        ("--html", "/proc/a.html", "nothing can be written"),
        ("--html", "folder.html/../text/a.html", "text is a file, not a folder"),
        ("--record", 250 * "a" + ".npz", "File name too long"),
        ("--record", 300 * "a" + ".npz", "File name too long"),
    ],
)
def test_an_output_that_cannot_be_written_stops_before_the_simulation(capsys, attempts, tmp_path, option, place, words):
    (tmp_path / "folder.html").mkdir()
    (tmp_path / "text").touch()
    status, out, err = answer(capsys, "run", "spheres_wall", option, tmp_path / place)
    assert (status, out, attempts) == (2, "", [])
    assert one_sentence(err)
    assert words in err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["folder.html", "text"]


def test_a_folder_that_may_not_be_looked_into_is_named(capsys, attempts, tmp_path, monkeypatch):
    looks = Path.is_dir

    def refuse(self):
        if tmp_path in self.parents:
            raise PermissionError(13, "Permission denied", str(self))
        return looks(self)

    monkeypatch.setattr(Path, "is_dir", refuse)
    status, out, err = answer(capsys, "run", "spheres_wall", "--html", tmp_path / "a.html")
    assert (status, out, attempts) == (2, "", [])
    assert one_sentence(err)
    assert f"{tmp_path}: Permission denied" in err


@pytest.mark.skipif(os.geteuid() == 0, reason="root may overwrite everything")
def test_a_protected_file_is_not_replaced(capsys, attempts, tmp_path):
    page = tmp_path / "a.html"
    page.write_text("old", encoding="utf-8")
    page.chmod(0o444)
    assert answer(capsys, "run", "spheres_wall", "--html", page)[0] == 2
    assert attempts == []


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "pilegrasp --help"),
        (["dance"], "No such command 'dance'; see `pilegrasp --help`"),
        (["run"], "Missing argument 'NAME|FILE.toml'; see `pilegrasp run --help`"),
        (["run", "spheres_wal"], "did you mean 'spheres_wall'"),
        (["run", "nowhere.toml"], "nowhere.toml: no such file"),
        (["run", "spheres_wall", "--seed", "-1"], "--seed"),
        (["run", "spheres_wall", "--seed", "one"], "--seed"),
        (["run", "spheres_wall", "--sed", "1"], "--sed"),
        (["run", "spheres_wall", "--set", "pile.cout=5"], "did you mean 'pile.count'"),
        (["run", "spheres_wall", "--set", "pile.count"], "key=value"),
        (
            ["run", "spheres_wall", "--set", "pile.count=-5"],
            "error: pile.count = -5 is not allowed: it must be at least 0",
        ),
        (["run", "spheres_wall", "--set", "support.tilt_deg=16"], "support.tilt_deg = 16 is not allowed"),
        (["run", "spheres_wall", "extra"], "extra"),
        (["export", "nowhere.npz", "page.html"], "nowhere.npz"),
        (["export", "nowhere.npz", "page.pdf"], "must end in .html"),
        (["export", "nowhere.npz"], "F.npz [G.npz]|DIR"),
    ],
)
@pytest.mark.parametrize("flags", [[], ["--json"]])
def test_an_error_is_one_sentence_and_status_2(capsys, attempts, tmp_path, monkeypatch, arguments, flags, words):
    monkeypatch.chdir(tmp_path)
    status, out, err = answer(capsys, *arguments, *(flags if arguments else []))
    assert (status, out, attempts) == (2, "", [])
    assert one_sentence(err)
    assert words in err
    assert list(tmp_path.iterdir()) == []


def test_an_error_of_the_library_is_its_sentence(capsys, attempts, monkeypatch):
    def fail(*_, **__):
        raise SimulationError("the arm left\n the range")

    monkeypatch.setattr(sys.modules["pilegrasp_ctrl.episode"], "run", fail)
    assert answer(capsys, "run", "spheres_wall", "--json") == (2, "", "error: the arm left the range\n")


def test_an_unexpected_error_says_how_to_see_more(capsys, attempts, monkeypatch):
    def fail(*_, **__):
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr(sys.modules["pilegrasp_ctrl.episode"], "run", fail)
    status, out, err = answer(capsys, "run", "spheres_wall")
    assert (status, out) == (2, "")
    assert one_sentence(err)
    assert "internal error (ZeroDivisionError: division by zero)" in err
    assert "--debug" in err


@pytest.mark.parametrize("arguments", [["--debug", "run", "nope"], ["run", "nope", "--debug"], ["run", "--debug"]])
def test_debug_shows_the_traceback_before_and_after_the_verb(capsys, arguments):
    status, out, err = answer(capsys, *arguments)
    assert (status, out) == (2, "")
    assert "Traceback" in err


def test_an_interrupt_is_status_130(capsys, attempts, monkeypatch):
    def interrupt(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(sys.modules["pilegrasp_ctrl.episode"], "run", interrupt)
    status, out, err = answer(capsys, "run", "spheres_wall")
    assert (status, out) == (130, "")
    assert "Traceback" not in err


def test_progress_is_shown_only_on_a_terminal(capsys, attempts, monkeypatch):
    _, _, err = answer(capsys, "run", "spheres_wall", "--json")
    attempts[0]["progress"](0.5, "push")
    assert err + capsys.readouterr().err == ""
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    status, out, _ = answer(capsys, "run", "spheres_wall", "--json")
    assert status == 0
    assert json.loads(out)
    attempts[1]["progress"](0.5, "push")


def test_export_writes_the_page(capsys, tmp_path):
    synthetic().save(tmp_path / "a.npz")
    status, out, err = answer(capsys, "export", tmp_path / "a.npz", tmp_path / "a.html")
    assert (status, out, err) == (0, f"{tmp_path / 'a.html'}\n", "")
    facts = json.loads(answer(capsys, "export", tmp_path / "a.npz", tmp_path / "b.html", "--json")[1])
    assert facts["html"] == str(tmp_path / "b.html")
    assert facts["bytes"] == (tmp_path / "b.html").stat().st_size > 0


@pytest.mark.parametrize("content", [b"", b"not a recording", b"PK\x03\x04 torn"])
def test_export_of_a_damaged_recording_leaves_no_page(capsys, tmp_path, content):
    (tmp_path / "a.npz").write_bytes(content)
    status, out, err = answer(capsys, "export", tmp_path / "a.npz", tmp_path / "a.html")
    assert (status, out) == (2, "")
    assert one_sentence(err)
    assert "a.npz" in err
    assert not (tmp_path / "a.html").exists()


def test_doctor_reports_every_check(capsys, attempts):
    status, out, err = answer(capsys, "doctor", "--json")
    report = json.loads(out)
    assert (status, err) == (0, "")
    assert report["ok"] is True
    rows = {row["name"]: row for row in report["checks"]}
    assert rows.keys() >= {*dependencies(), "solver daqp", "solver osqp", "engines agree", "browser", "short run"}
    assert all(row["ok"] for row in rows.values() if row["required"])


def test_doctor_fails_if_a_check_fails(capsys, attempts, monkeypatch):
    monkeypatch.setattr(doctor, "AGREEMENT", 1e-30)
    monkeypatch.setattr(doctor, "dependencies", lambda: ("numpy", "a-package-that-is-not-there"))
    status, out, err = answer(capsys, "doctor", "--json")
    assert status == 2
    assert err == "error: these checks failed: a-package-that-is-not-there, engines agree\n"
    assert json.loads(out)["ok"] is False
    status, out, err = answer(capsys, "doctor")
    assert status == 2
    assert "failed" in out


def test_a_missing_browser_is_no_failure(capsys, attempts, monkeypatch):
    monkeypatch.setenv("PATH", "")
    report = json.loads(answer(capsys, "doctor", "--json")[1])
    assert "Everything that is needed works.\n" in answer(capsys, "doctor")[1]
    assert report["ok"] is True
    assert [row["ok"] for row in report["checks"] if row["name"] == "browser"] == [False]
