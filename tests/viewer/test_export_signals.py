"""A signal while pictures are drawn ends the browser and the encoder, and leaves no file."""

import contextlib
import os
import signal
import stat
import subprocess
import sys
import time

import pytest

from pilegrasp_ctrl.exceptions import ExportError
from pilegrasp_ctrl.interruption import signals_wait
from pilegrasp_ctrl.viewer.pictures import movie
from pilegrasp_ctrl.viewer.pictures.chromium import Chromium
from places import ROOT
from processes import is_there
from synthetic_recording import synthetic

ENCODER = """#!/bin/sh
for last; do :; done
echo part > "${last#file:}"
exec cat > /dev/null
"""
"""An encoder that writes to its last argument and swallows pictures."""


@pytest.fixture
def place(tmp_path):
    for name in ("work", "tmp", "bin"):
        (tmp_path / name).mkdir()
    synthetic(frames=60).save(tmp_path / "work" / "a.npz")
    encoder = tmp_path / "bin" / "ffmpeg"
    encoder.write_text(ENCODER)
    encoder.chmod(encoder.stat().st_mode | stat.S_IXUSR)
    return tmp_path


def begin(place, output):
    environment = os.environ | {"PYTHONPATH": str(ROOT), "TMPDIR": str(place / "tmp")}
    environment["PATH"] = f"{place / 'bin'}:{environment['PATH']}"
    return subprocess.Popen(
        [sys.executable, "-m", "pilegrasp_ctrl", "export", "a.npz", output],
        cwd=place / "work",
        env=environment,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def using(word):
    """Return the processes that run and have the word in their arguments."""
    found = []
    for name in filter(str.isdigit, os.listdir("/proc")):
        with contextlib.suppress(OSError), open(f"/proc/{name}/cmdline", "rb") as file:
            if word.encode() in file.read() and is_there(int(name)):
                found.append(int(name))
    return found


@pytest.mark.slow
@pytest.mark.browser
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("output", ["a.gif", "a.mp4", "a.png"])
@pytest.mark.parametrize("after", [0.0, 0.3, 2.0])
def test_a_signal_during_an_export_leaves_nothing(place, output, number, after):
    process = begin(place, output)
    while process.poll() is None and not list((place / "tmp").glob("chromium-*")):
        time.sleep(0.005)
    time.sleep(after)
    assert process.poll() is None, process.communicate()
    process.send_signal(number)
    assert process.communicate() == ("", "")
    assert process.returncode == 130
    assert list((place / "tmp").iterdir()) == []
    assert [path.name for path in (place / "work").iterdir()] == ["a.npz"]
    assert using(str(place / "tmp")) == []


def test_signals_wait_for_the_end_of_a_block(monkeypatch):
    done = []
    with pytest.raises(KeyboardInterrupt):  # noqa: PT012
        with signals_wait():
            for _ in range(2):
                os.kill(os.getpid(), signal.SIGINT)
                time.sleep(0.01)
            done.append("block")
        done.append("behind")
    assert done == ["block"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_a_browser_that_does_not_start_leaves_no_profile(monkeypatch, tmp_path):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with pytest.raises(ExportError, match="ended by itself"):
        Chromium("/bin/false")
    assert list(tmp_path.iterdir()) == []


def test_an_encoder_that_is_interrupted_leaves_no_part_of_a_movie(place, monkeypatch):
    def pictures():
        yield b"one"
        while not list((place / "work").glob(".a.mp4.*")) or not next((place / "work").glob(".a.mp4.*")).stat().st_size:
            time.sleep(0.01)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        movie.encode_mp4(str(place / "bin" / "ffmpeg"), pictures(), 15.0, place / "work" / "a.mp4")
    assert [path.name for path in (place / "work").iterdir()] == ["a.npz"]
    assert using(str(place)) == []
