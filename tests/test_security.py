"""What `docs/security.md` promises: nothing listens beyond this machine, and a received file is data, never code."""

import io
import os
import pickle
import signal
import subprocess
import sys
import time
import zipfile

import numpy as np
import pytest

from file_inputs import study_bytes
from pilegrasp_ctrl.exceptions import PilegraspError
from pilegrasp_ctrl.recording import Recording
from places import ROOT
from processes import descendants, listening, members
from synthetic_recording import synthetic

LINE = ("free_space_line", "--set", "line.displacement=[0.0, 0.02, 0.0]")
COMMANDS = {
    "run": ("run", *LINE, "--record", "b.npz", "--html", "b.html"),
    "run --live": ("run", *LINE, "--live"),
    "sweep": ("sweep", *LINE, "--seeds", "0:2", "--jobs", "2", "--out", "study"),
    "search": (
        *("search", "spheres_wall", "--set", "pile.count=1", "--over", "strategy.grasp_force=8,9", "--budget", "16"),
        *("--judge", "9000:9001", "--jobs", "2", "--out", "found"),
    ),
    "paper": ("paper", "fig06", "--attempts", "1", "--jobs", "2", "--out", "study"),
    "tune": ("tune", *LINE, "--trials", "1", "--jobs", "2", "--out", "search"),
    "check": ("check", "free_space_line"),
    "show": ("show", "spheres_wall"),
    "export": ("export", "a.npz", "a.png"),
    "export to Rerun": ("export", "a.npz", "a.rrd"),
    "export to Foxglove": ("export", "a.npz", "a.mcap"),
    "report": ("report", "made"),
    "list": ("list",),
    "bench": ("bench", "--quick"),
    "doctor": ("doctor",),
}
"""A command for each verb, and for what else opens a port."""

LOOPBACK = {"127.0.0.1", "::1"}
"""Addresses that only this machine reaches."""

PATIENCE = 12.0
"""Time after which a command that listens nowhere is interrupted [s], chosen: by then its workers run."""

WATCH = """
import os, sys

def note(event, arguments):
    if event == "socket.bind" and isinstance(arguments[1], tuple):
        with open(os.environ["BOUND"], "a") as file:
            file.write(f"{arguments[1][0]}\\n")

sys.addaudithook(note)
"""
"""Module that every Python process imports when it starts; it writes down each address to which a socket is bound."""


def test_every_verb_has_a_command_here():
    from typer.main import get_command

    from pilegrasp_ctrl.cli import app

    assert set(get_command(app).commands) == {call[0] for call in COMMANDS.values()}


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.browser if name == "export" else ()) for name in COMMANDS]
)
def test_no_verb_listens_beyond_the_loopback(name, tmp_path):
    synthetic(frames=30).save(tmp_path / "a.npz")
    (tmp_path / "made").mkdir()
    (tmp_path / "made" / "study.db").write_bytes(study_bytes())
    (tmp_path / "site").mkdir()
    (tmp_path / "site" / "sitecustomize.py").write_text(WATCH)
    environment = os.environ | {"PYTHONPATH": f"{tmp_path / 'site'}:{ROOT}", "BOUND": str(tmp_path / "bound")}
    process = subprocess.Popen(
        [sys.executable, "-m", "pilegrasp_ctrl", *COMMANDS[name]],
        cwd=tmp_path,
        env=environment,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    # A browser is in a session of its own, and is no Python process.
    patience = 60.0 if name == "run --live" else PATIENCE
    found, family, end = set(), {process.pid}, time.monotonic() + patience
    try:
        while process.poll() is None and time.monotonic() < end and not (name == "run --live" and found):
            family |= set(members(process.pid)) | set(descendants(family))
            for number in family:
                found.update(address for address, _ in listening(number))
            time.sleep(0.2)
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGINT)
        said, _ = process.communicate()
    bound = set((tmp_path / "bound").read_text().split()) if (tmp_path / "bound").exists() else set()
    # A signal that comes when all is done meets Python's own handler.
    assert process.returncode in (0, 130, -signal.SIGINT), said
    assert found | bound <= LOOPBACK
    assert bool(found | bound) is (name == "run --live")


class Planted:
    """An object whose pickle makes a file when it is loaded."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return os.mkdir, (str(self.path),)


@pytest.mark.parametrize("entry", ["header", "body_position", "signal/q", "planted"])
def test_a_recording_cannot_carry_code(entry, tmp_path):
    synthetic(frames=3).save(tmp_path / "a.npz")
    buffer = io.BytesIO()
    np.save(buffer, np.array([Planted(tmp_path / "made")], dtype=object), allow_pickle=True)
    with zipfile.ZipFile(tmp_path / "a.npz") as archive, zipfile.ZipFile(tmp_path / "b.npz", "w") as made:
        for name in archive.namelist():
            if name != f"{entry}.npy":
                made.writestr(name, archive.read(name))
        made.writestr(f"{entry}.npy", buffer.getvalue())
    with pytest.raises(PilegraspError):
        Recording.load(tmp_path / "b.npz")
    assert not (tmp_path / "made").exists()
    pickle.loads(pickle.dumps(Planted(tmp_path / "made")))
    assert (tmp_path / "made").exists()
