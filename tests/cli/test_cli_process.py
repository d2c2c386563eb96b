"""The command line as a process, `python -m pilegrasp_ctrl`: streams that close, real attempts, and the scripts."""

import json
import os
import subprocess
import sys

import pytest

from command_line import JSON_KEYS, one_sentence
from pilegrasp_ctrl import cli
from pilegrasp_ctrl.provenance import VERSION
from pilegrasp_ctrl.scenarios import FOLDER
from places import ROOT


def pilegrasp(*arguments, cwd):
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "pilegrasp_ctrl", *map(str, arguments)]
    return subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True, check=False)


def in_a_shell(line, cwd):
    """Run a line of a shell in which `pilegrasp` is the command under test; return its status and standard error."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHON": sys.executable}
    line = f'pilegrasp() {{ "$PYTHON" -m pilegrasp_ctrl "$@"; }}; {line}'
    done = subprocess.run(["bash", "-c", line], cwd=cwd, env=environment, capture_output=True, text=True, check=False)
    return done.returncode, done.stderr


def test_the_package_runs_as_a_module(tmp_path):
    done = pilegrasp("--version", cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (0, f"{VERSION}\n", "")
    assert pilegrasp("nothing", cwd=tmp_path).returncode == 2


@pytest.mark.parametrize("flags", ["", "--json"])
def test_a_reader_that_leaves_is_no_error(tmp_path, flags):
    assert in_a_shell(f"pilegrasp list {flags} | true; exit ${{PIPESTATUS[0]}}", tmp_path) == (cli.READER_LEFT, "")


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("pilegrasp list >&-", "standard output is closed"),
        ("pilegrasp list >/dev/full", "standard output cannot be written: No space left on device"),
        ("pilegrasp list --json >/dev/full", "standard output cannot be written: No space left on device"),
    ],
)
def test_a_result_that_cannot_be_printed_is_an_error(tmp_path, line, words):
    status, err = in_a_shell(line, tmp_path)
    assert status == 2
    assert one_sentence(err)
    assert words in err


def test_a_closed_standard_error_takes_nothing_from_the_result(tmp_path):
    assert in_a_shell("pilegrasp list --json 2>&- | grep -q spheres_wall", tmp_path)[0] == 0
    assert in_a_shell('test -z "$(pilegrasp run nope 2>&-)"', tmp_path)[0] == 0
    assert in_a_shell("pilegrasp run nope 2>&-", tmp_path)[0] == 2


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scenario", "settings"),
    [
        ("free_space_line", ["--set", "line.displacement=[0.0, 0.05, 0.0]"]),
        ("free_space_line", ["--set", "line.displacement=[0.0, 0.05, 0.0]", "--set", "controller.solver=osqp"]),
        ("push_wall", []),
    ],
)
def test_a_real_attempt_end_to_end(tmp_path, scenario, settings):
    done = pilegrasp("run", scenario, *settings, "--json", "--record", "a.npz", "--html", "a.html", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    facts = json.loads(done.stdout)
    assert facts.keys() >= JSON_KEYS
    assert facts["success"] is True
    assert facts["controller"]["ticks"] > 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.html", "a.npz"]
    exported = pilegrasp("export", "a.npz", "b.html", cwd=tmp_path)
    assert exported.returncode == 0, exported.stderr
    assert (tmp_path / "b.html").read_bytes() == (tmp_path / "a.html").read_bytes()


@pytest.mark.slow
def test_a_real_doctor_finds_nothing_wrong(tmp_path):
    done = pilegrasp("doctor", "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert json.loads(done.stdout)["ok"] is True


@pytest.mark.slow
@pytest.mark.parametrize("script", sorted(path.name for path in FOLDER.glob("[!_]*.py")))
def test_a_script_runs_unchanged(tmp_path, script):
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, str(FOLDER / script)]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout
