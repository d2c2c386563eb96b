"""Errors of pictures and movies that cannot be written, and the files that remain."""

from __future__ import annotations

import os
import shutil
import sys

import pytest

from browser import program
from pilegrasp_ctrl import cli
from pilegrasp_ctrl.exceptions import ExportError
from pilegrasp_ctrl.viewer import write
from pilegrasp_ctrl.viewer.pictures.stills import Stills
from synthetic_recording import synthetic

SPEED = 20.0


FAILING_FFMPEG = """#!/bin/sh
echo "Unknown encoder" >&2
exit 1
"""


@pytest.fixture(scope="module")
def attempt():
    return synthetic(frames=60, objects=6)


@pytest.fixture
def saved(attempt, tmp_path):
    attempt.save(tmp_path / "a.npz")
    return tmp_path / "a.npz"


def answer(capsys, *arguments):
    status = cli.main([str(argument) for argument in arguments])
    out, err = capsys.readouterr()
    return status, out, err


def assert_one_sentence(err):
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    assert "internal" not in err


def assert_refused(capsys, saved, name, *words):
    """The export ends with status 2 and one sentence, and the folder is as it was."""
    before = sorted(saved.parent.iterdir())
    status, out, err = answer(capsys, "export", saved, saved.parent / name)
    assert (status, out) == (2, "")
    assert_one_sentence(err)
    for word in words:
        assert word in err
    assert sorted(saved.parent.iterdir()) == before


@pytest.mark.parametrize("name", ["a.png", "a.gif"])
def test_without_chromium_one_sentence_says_what_to_install(capsys, saved, monkeypatch, name):
    monkeypatch.delenv("PILEGRASP_CHROMIUM", raising=False)
    monkeypatch.setattr(shutil, "which", lambda name: None)
    assert_refused(capsys, saved, name, "Chromium", "apt-get install chromium", "PILEGRASP_CHROMIUM")


@pytest.mark.parametrize(
    ("browser", "words"), [("/nowhere/chromium", "which is not a program"), ("false", "ended by itself")]
)
def test_a_browser_that_does_not_start_is_named(capsys, saved, monkeypatch, browser, words):
    monkeypatch.setenv("PILEGRASP_CHROMIUM", browser)
    assert_refused(capsys, saved, "a.png", browser, words)


def test_without_ffmpeg_one_sentence_names_both_remedies(capsys, saved, monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    assert_refused(capsys, saved, "a.mp4", "apt-get install ffmpeg", "pip install imageio-ffmpeg", ".gif works")


@pytest.mark.slow
@pytest.mark.browser
def test_an_ffmpeg_that_fails_is_quoted(chromium, capsys, saved, tmp_path, monkeypatch):
    tools = tmp_path / "tools"
    tools.mkdir()
    program(tools, "ffmpeg", FAILING_FFMPEG)
    monkeypatch.setenv("PATH", f"{tools}{os.pathsep}{os.environ['PATH']}")
    assert_refused(capsys, saved, "a.mp4", "Unknown encoder")


@pytest.mark.slow
@pytest.mark.browser
def test_an_interrupt_leaves_neither_a_file_nor_a_browser(chromium, attempt, tmp_path, monkeypatch):
    begun = []
    draw = Stills.frame

    def interrupted(self, *arguments):
        begun.append(self)
        if len(begun) == 3:
            raise KeyboardInterrupt
        return draw(self, *arguments)

    monkeypatch.setattr(Stills, "frame", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write(attempt, tmp_path / "a.gif", speed=SPEED)
    assert list(tmp_path.iterdir()) == []
    assert begun[0]._browser._process.poll() is not None


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["a.html", "--speed", "2"], "--speed is for movies"),
        (["a.png", "--speed", "2"], "--speed is for movies"),
        (["a.gif", "--speed", "0"], "out of range"),
        (["a.gif", "--speed", "nan"], "out of range"),
        (["a.webm"], "must end in .html, .png, .gif, .mp4, .csv, .rrd or .mcap"),
        (["nowhere/a.gif"], "does not exist"),
    ],
)
def test_an_export_that_cannot_be_written_is_an_error(capsys, saved, arguments, words):
    name, *options = arguments
    status, out, err = answer(capsys, "export", saved, saved.parent / name, *options)
    assert (status, out) == (2, "")
    assert_one_sentence(err)
    assert words in err
    assert [path.name for path in saved.parent.iterdir()] == ["a.npz"]


def test_write_knows_no_other_suffix(attempt, tmp_path):
    with pytest.raises(ExportError, match=r"must end in \.html, \.png, \.gif, \.mp4, \.csv, \.rrd or \.mcap"):
        write(attempt, tmp_path / "a.pdf")


def test_run_refuses_a_picture_it_could_not_draw_before_it_simulates(capsys, tmp_path, monkeypatch):
    monkeypatch.setattr("pilegrasp_ctrl.episode.run", lambda *_, **__: pytest.fail("the attempt has begun"))
    monkeypatch.setenv("PILEGRASP_CHROMIUM", "/nowhere/chromium")
    status, out, err = answer(capsys, "run", "spheres_wall", "--export", tmp_path / "a.png")
    assert (status, out) == (2, "")
    assert_one_sentence(err)
    assert list(tmp_path.iterdir()) == []


def test_run_exports_by_the_suffix(capsys, tmp_path):
    short = ["--set", "line.displacement=[0.0, 0.02, 0.0]"]
    files = ["--html", tmp_path / "a.html", "--export", tmp_path / "b.html"]
    status, out, _ = answer(capsys, "run", "free_space_line", *short, *files)
    assert status == 0
    assert f"wrote {tmp_path / 'b.html'}" in out
    assert (tmp_path / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()
