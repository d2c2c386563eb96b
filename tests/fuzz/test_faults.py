"""Faults of the machine: a full disk, a home that is read-only, a clock that jumps, two processes at one place."""

import json
import os
import shutil
import subprocess
import sys
import time
from functools import cache
from pathlib import Path

import pytest

from command_line import one_sentence
from pilegrasp_ctrl import run
from pilegrasp_ctrl.study import run as study_run
from pilegrasp_ctrl.study.attempt import repeatable
from pilegrasp_ctrl.study.condition import conditions
from pilegrasp_ctrl.study.dispatch import InlinePool
from pilegrasp_ctrl.study.run import run_study
from places import ROOT

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="disks are made small by Linux's mounts")

SHORT = {"line.displacement": [0.0, 0.02, 0.0]}
LINE = ("free_space_line", "--set", "line.displacement=[0.0, 0.02, 0.0]")
SWEEP = ("sweep", *LINE, "--vary", "line.speed=0.2,0.3", "--seeds", "0:3", "--jobs", "1", "--record", "all", "--out")
FULL = ("No space left on device", "disk is full", "disk I/O error", "File too large")
"""How the system, or SQLite, says that nothing more fits."""


@cache
def mounts_are_allowed():
    """Return whether this user can mount a file system that nobody else sees."""
    if shutil.which("unshare") is None:
        return False
    done = subprocess.run(["unshare", "-rm", "mount", "-t", "tmpfs", "none", "/mnt"], capture_output=True, check=False)
    return done.returncode == 0


def pilegrasp(*arguments, cwd, disk=None, size="300k", options="", **variables):
    """Run a command; the folder `disk`, if there is one, is a file system of `size`, whose files are listed afterwards.

    Where no file system can be mounted, the largest file may have this size instead.
    """
    environment = os.environ | {"PYTHONPATH": str(ROOT)} | variables
    command = [sys.executable, "-m", "pilegrasp_ctrl", *map(str, arguments)]
    if disk is None:
        done = subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True, check=False)
        return done, []
    listing = Path(cwd) / "listing"
    inner = f'"$@"; status=$?; (cd {disk} && find . -type f) > {listing}; exit $status'
    if mounts_are_allowed():
        inner = f"mount -t tmpfs -o size={size}{options} none {disk} && cd {cwd} && {{ {inner}; }}"
        command = ["unshare", "-rm", "bash", "-c", inner, "bash", *command]
    else:
        command = ["bash", "-c", f"ulimit -f {size.rstrip('k')}; {inner}", "bash", *command]
    done = subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True, check=False)
    return done, [line[2:] for line in listing.read_text().splitlines()]


@pytest.mark.slow
def test_a_study_on_a_full_disk_ends_in_a_sentence_and_leaves_no_part_of_a_file(tmp_path):
    disk = tmp_path / "disk"
    disk.mkdir()
    done, left = pilegrasp(*SWEEP, disk / "study", cwd=tmp_path, disk=disk, size="100k")
    assert done.returncode == 2, done.stderr
    assert one_sentence(done.stderr)
    assert any(words in done.stderr for words in FULL), done.stderr
    assert not [name for name in left if name.endswith(".part")]


@pytest.mark.slow
def test_a_page_that_does_not_fit_leaves_nothing(tmp_path):
    disk = tmp_path / "disk"
    disk.mkdir()
    done, left = pilegrasp("run", *LINE, "--html", disk / "a.html", cwd=tmp_path, disk=disk, size="100k")
    assert done.returncode == 2
    assert one_sentence(done.stderr)
    assert any(words in done.stderr for words in FULL)
    assert left == []


@pytest.mark.slow
@pytest.mark.parametrize("place", ["TMPDIR", "XDG_CACHE_HOME"])
def test_a_full_temporary_folder_or_cache_changes_no_result(place, tmp_path):
    disk = tmp_path / "disk"
    disk.mkdir()
    here, there = tmp_path / "here", tmp_path / "there"
    plain, _ = pilegrasp(*SWEEP, here, "--json", cwd=tmp_path)
    full, left = pilegrasp(*SWEEP, there, "--json", cwd=tmp_path, disk=disk, size="4k", **{place: str(disk)})
    assert (full.returncode, full.stderr) == (0, "")
    assert full.stdout == plain.stdout
    assert [row["errors"] for row in json.loads(full.stdout)] == [0, 0]
    assert left == []
    recordings = [sorted((study / "recordings").glob("*.npz")) for study in (here, there)]
    assert [file.read_bytes() for file in recordings[0]] == [file.read_bytes() for file in recordings[1]]


@pytest.mark.slow
@pytest.mark.parametrize("home", ["read-only", "/dev/null", "missing", ""])
def test_a_home_that_cannot_be_written_takes_nothing_from_an_attempt(home, tmp_path):
    disk = tmp_path / "disk"
    disk.mkdir()
    arguments = ("run", "spheres_wall", "--set", "pile.count=1", "--set", "program=push", "--json")
    if home == "read-only" and not mounts_are_allowed():
        pytest.skip("no file system can be mounted")
    place = {"read-only": str(disk), "missing": str(tmp_path / "missing")}.get(home, home)
    options = ",ro" if home == "read-only" else ""
    variables = {"HOME": place, "XDG_CACHE_HOME": "", "XDG_CONFIG_HOME": ""}
    done, _ = pilegrasp(*arguments, cwd=tmp_path, disk=disk if options else None, options=options, **variables)
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout)["scenario"] == "spheres_wall"
    assert not (tmp_path / "missing").exists() or home == "missing"


def jumping(jumps):
    """Return a clock that jumps to and fro by hours and years."""
    true, count = time.time, 0

    def clock():
        nonlocal count
        count += 1
        return true() + jumps[count % len(jumps)]

    return clock


def test_a_clock_that_jumps_changes_no_result(tmp_path, monkeypatch):
    monkeypatch.setattr(study_run, "open_pool", lambda jobs, scheduler: InlinePool())
    attempts = [(condition, 0) for condition in conditions("free_space_line", {"line.speed": [0.3]}, SHORT)]

    def study(folder):
        with run_study(attempts, folder, jobs=1, record="all") as store:
            (row,) = store.attempts()
            return row, store.recording_file(row.config_hash, 0).read_bytes()

    expected = study(tmp_path / "steady")
    result = repeatable(run("free_space_line", overrides=SHORT))
    monkeypatch.setattr(time, "time", jumping([0.0, -3600.0, 1e9, -1e9, 0.5, -2e9]))
    assert study(tmp_path / "jumping") == expected
    assert repeatable(run("free_space_line", overrides=SHORT)) == result
    assert json.dumps(result) == json.dumps(repeatable(run("free_space_line", overrides=SHORT)))


@pytest.mark.slow
def test_two_processes_at_one_study_and_one_cache(tmp_path):
    environment = os.environ | {"PYTHONPATH": str(ROOT), "XDG_CACHE_HOME": str(tmp_path / "cache")}

    def begin(*arguments):
        command = [sys.executable, "-m", "pilegrasp_ctrl", *map(str, arguments)]
        return subprocess.Popen(
            command, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )

    grasp = ("run", "spheres_wall", "--set", "pile.count=2", "--set", "program=push", "--seed", "4", "--json")
    processes = [begin(*grasp), begin(*grasp), begin(*SWEEP, "study", "--json"), begin(*SWEEP, "study", "--json")]
    answers = [process.communicate() for process in processes]
    first, second = ({**json.loads(out), "controller": 0} for out, _ in answers[:2])
    for clocked in ("wall_time", "realtime_factor"):
        del first[clocked], second[clocked]
    assert first == second
    refused = [err for process, (_, err) in zip(processes[2:], answers[2:], strict=True) if process.returncode == 2]
    assert len(refused) <= 1
    assert all(one_sentence(err) and "another study writes there now" in err for err in refused)
    done = begin(*SWEEP, "study", "--json")
    out, err = done.communicate()
    assert (done.returncode, err) == (0, "")
    assert [row["n"] for row in json.loads(out)] == [3, 3]
