"""A study that is killed or interrupted loses no finished attempt, repeats none, and leaves no process behind."""

import json
import os
import random
import signal
import sqlite3
import subprocess
import sys
import time

import pytest

from pilegrasp_ctrl.study.store import StudyStore
from places import ROOT
from processes import children, wait_until_gone
from study_tasks import attempts

TESTS = ROOT / "tests" / "helpers"
# The slower line takes long enough to be interrupted.
LINE = ["free_space_line", "--set", "line.displacement=[0.0,0.02,0.0]", "--vary", "line.speed=0.3,0.005"]
MAIN = "import sys; from pilegrasp_ctrl.cli import main; sys.exit(main())"
SWEEP = [sys.executable, "-c", MAIN, "sweep", *LINE, "--seeds", "0:2", "--json"]


pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="processes are looked up in /proc"),
]


def begin(command, **variables):
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(TESTS), *sys.path])} | variables
    # In its own process group a Ctrl-C reaches the workers too, as in a terminal. A background job would ignore it.
    return subprocess.Popen(
        command,
        env=environment,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def rows(folder):
    """Read the table with SQLite alone; reading rolls back what a killed writer left half-done."""
    if not (folder / "study.db").exists():
        return []
    with sqlite3.connect(folder / "study.db", timeout=60) as connection:
        if not connection.execute("SELECT name FROM sqlite_master WHERE name = 'attempts'").fetchone():
            return []
        return connection.execute("SELECT * FROM attempts ORDER BY config_hash, seed").fetchall()


def wait_for_rows(folder, count, process):
    while len(rows(folder)) < count:
        assert process.poll() is None, process.communicate()
        time.sleep(0.01)


def finish(process):
    out, err = process.communicate()
    assert process.returncode == 0, err
    return out


@pytest.mark.slow
def test_killed_twice_at_random_moments_the_table_is_that_of_an_uninterrupted_study(tmp_path):
    moments = random.Random(5)
    script = [sys.executable, str(TESTS / "study_tasks.py")]
    finish(begin([*script, str(tmp_path / "whole")]))
    killed, total = tmp_path / "killed", len(attempts(60))
    for halt in (10, 40):
        process = begin([*script, str(killed)], HALT=str(halt))
        # The first of the two conditions gets no further than this seed.
        wait_for_rows(killed, halt - moments.randint(3, 8), process)
        time.sleep(moments.uniform(0.0, 0.05))
        workers = children(process)
        process.kill()
        process.communicate()
        assert len(workers) >= 2
        wait_until_gone(workers)
        assert 0 < len(rows(killed)) < total
    finish(begin([*script, str(killed)]))
    assert rows(killed) == rows(tmp_path / "whole")
    assert len(rows(killed)) == total


@pytest.mark.slow
def test_a_sweep_that_is_interrupted_and_killed_ends_as_if_it_had_not_been(tmp_path):
    whole, stopped = tmp_path / "whole", tmp_path / "stopped"
    expected = finish(begin([*SWEEP, "--jobs", "1", "--out", str(whole)]))
    process = begin([*SWEEP, "--jobs", "2", "--out", str(stopped)])
    wait_for_rows(stopped, 1, process)
    os.killpg(process.pid, signal.SIGINT)
    out, err = process.communicate()
    assert (process.returncode, out) == (130, "")
    assert err == f"stopped; finished attempts are kept in {stopped}; the same command runs the rest\n"
    assert 1 <= len(rows(stopped)) < 4
    process = begin([*SWEEP, "--jobs", "2", "--out", str(stopped)])
    while len(workers := children(process)) < 2:
        assert process.poll() is None, process.communicate()
        time.sleep(0.01)
    time.sleep(0.3)
    process.kill()
    process.communicate()
    wait_until_gone(workers)
    assert len(rows(stopped)) < 4
    assert finish(begin([*SWEEP, "--jobs", "2", "--out", str(stopped)])) == expected
    after = rows(stopped)
    assert after == rows(whole)
    assert [row["n"] for row in json.loads(expected)] == [2, 2]
    with StudyStore(stopped) as store:
        assert set(store.costs()) == {row[:2] for row in after}
