"""Arguments of any length, number and encoding: one sentence, soon, or they work."""

import os
import subprocess
import sys
import time

import pytest

from command_line import answer, one_sentence
from pilegrasp_ctrl import cli
from pilegrasp_ctrl.config import parse_overrides
from pilegrasp_ctrl.exceptions import MAX_SENTENCE, MAX_WORD, ConfigurationError, PilegraspError
from pilegrasp_ctrl.study import MAX_ATTEMPTS, MAX_CONDITIONS
from pilegrasp_ctrl.study.condition import conditions
from pilegrasp_ctrl.study.run import run_study
from places import ROOT
from synthetic_recording import synthetic

SOON = 10.0
"""Longest time to a refusal [s], on a busy machine."""

LONG = 6000 * "9"
VALUES = ",".join(f"0.{k}" for k in range(100, 130))
EIGHT_KEYS = [
    "strategy.speed",
    "strategy.alpha_deg",
    "strategy.beta_deg",
    "strategy.theta_deg",
    "strategy.lift_height",
    "pile.mass",
    "pile.scale",
    "pile.friction",
]
GRID = [word for key in EIGHT_KEYS for word in ("--vary", f"{key}={VALUES}")]
NESTED = 5000 * "["


def refused(capsys, *arguments):
    """Return the sentence of a command that is refused."""
    begun = time.monotonic()
    status, out, err = answer(capsys, *arguments)
    assert (status, out) == (2, "")
    assert one_sentence(err)
    assert "internal error" not in err
    assert time.monotonic() - begun < SOON
    return err


# --- numbers without end ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["sweep", "spheres_wall", "--seeds", "0:300000000"], "asks for 3e+08 attempts; 1000000 are allowed"),
        (["sweep", "spheres_wall", "--seeds", f"0:{10**30}"], "the largest seed is"),
        (["sweep", "spheres_wall", "--seeds", f"0:{LONG}"], "must be FIRST:LAST"),
        (["sweep", "spheres_wall", "--seeds", "0:1", *GRID], "6.56e+11 combinations; 10000 are allowed"),
        (["sweep", "spheres_wall", "--seeds", "0:999999", "--vary", "pile.count=3,5"], "ask for 2e+06 attempts"),
        (["sweep", "spheres_wall", "--seeds", "0:1", "--vary", f"pile.count={LONG}"], "this is not a value"),
        (["sweep", "spheres_wall", "--seeds", "0:1", "--vary", f"pile.count={NESTED}"], "nested too deeply"),
        (["sweep", "spheres_wall", "--seeds", "0:1", "--jobs", str(10**12)], "less than or equal to 1000"),
        (["run", "spheres_wall", "--set", f"pile.count={LONG}"], "this is not a value"),
        (["run", "spheres_wall", "--set", f"pile.count={NESTED}"], "nested too deeply"),
        (["run", "spheres_wall", "--set", "pile.count={" + 40 * "a." + "a=1}"], "more than 32 parts"),
        (["run", "spheres_wall", "--seed", str(10**30)], "less than or equal to"),
        (["run", "spheres_wall", "--seed", LONG], "maximum size"),
        (["tune", "free_space_line", "--jobs", str(10**12)], "less than or equal to 1000"),
        (["tune", "free_space_line", "--trials", str(10**12)], "less than or equal to 10000"),
        (["paper", "fig06", "--seeds-from", str(10**30)], "less than or equal to"),
    ],
)
def test_what_has_no_end_is_refused_before_anything_is_built(capsys, tmp_path, arguments, words):
    out = [] if arguments[0] == "run" else ["--out", tmp_path / "out"]
    assert words in refused(capsys, *arguments, *out)
    assert list(tmp_path.iterdir()) == []


def test_a_study_from_python_has_the_same_bounds(tmp_path):
    with pytest.raises(ConfigurationError, match=f"{MAX_CONDITIONS} are allowed"):
        conditions("spheres_wall", {key: list(range(100)) for key in EIGHT_KEYS})
    with pytest.raises(ConfigurationError, match=f"{MAX_ATTEMPTS} are allowed at once"):
        run_study(range(MAX_ATTEMPTS + 1), tmp_path)


# --- nothing is ignored -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run", "push_wall", "--set", "pile.count=5\npile.mass=1"], "one line without control characters"),
        (["run", "push_wall", "--set", "pile.count=5 # balls"], "what is behind # would be ignored"),
        (["sweep", "push_wall", "--seeds", "0:1", "--vary", "pile.count=5\nx=[1"], "one line"),
        (["sweep", "push_wall", "--seeds", "0:1", "--vary", "pile.count=5,6 # balls"], "what is behind #"),
        (["paper", "all", "fig99"], "there is no experiment 'fig99'"),
    ],
)
def test_a_part_of_an_argument_that_would_be_ignored_is_refused(capsys, tmp_path, arguments, words):
    out = [] if arguments[0] == "run" else ["--out", tmp_path / "out"]
    assert words in refused(capsys, *arguments, *out)
    assert list(tmp_path.iterdir()) == []


def test_a_speed_for_a_table_is_refused(capsys, tmp_path):
    assert "--speed is for movies" in refused(capsys, "export", tmp_path, tmp_path / "a.csv", "--speed", "2")


@pytest.mark.parametrize(("text", "value"), [("a#b", "a#b"), ("a # b", "a # b"), ('"a # b"', "a # b"), ("1,2", "1,2")])
def test_a_text_with_a_hash_in_it_is_a_text(text, value):
    assert parse_overrides([f"name={text}"]) == {"name": value}


# --- names of any length ----------------------------------------------------------------------------------------------

NAME = 6000 * "x"


@pytest.mark.parametrize(
    "arguments",
    [
        [NAME],
        ["run", NAME],
        ["run", f"--{NAME}"],
        ["run", "push_wall", "--set", NAME],
        ["run", "push_wall", "--set", f"{NAME}=1"],
        ["run", "push_wall", "--set", f"pile.count={NAME}"],
        ["run", "push_wall", "--set", f"robot={NAME}"],
        ["run", "push_wall", "--set", f"pile.object={NAME}"],
        ["run", "push_wall", "--set", f"pile.object=/{NAME}.toml"],
        ["run", "push_wall", "--set", f"controller.gains={NAME}"],
        ["run", "push_wall", "--html", f"{NAME}.html"],
        ["list", "--tag", NAME],
        ["export", NAME, "a.html"],
        ["export", "a.npz", NAME],
        ["report", NAME],
        ["bench", "--compare", NAME],
        ["paper", NAME, "--out", "out"],
        ["paper", "fig06", "--out", NAME],
        ["tune", "free_space_line", "--start", NAME, "--out", "out"],
        ["tune", "free_space_line", "--out", NAME],
        ["sweep", "push_wall", "--seeds", NAME, "--out", "out"],
        ["sweep", "push_wall", "--seeds", "0:1", "--out", NAME],
        ["sweep", "push_wall", "--seeds", "0:1", "--vary", f"{NAME}=1", "--out", "out"],
    ],
)
def test_an_over_long_name_is_shortened(capsys, tmp_path, monkeypatch, arguments):
    monkeypatch.chdir(tmp_path)
    err = refused(capsys, *arguments)
    # Of another part of the sentence, such as a list of names, no word is as long.
    assert max(map(len, err.split())) <= MAX_WORD
    assert len(err) < MAX_SENTENCE


def test_an_error_from_python_is_shortened_too():
    text = str(PilegraspError(f"{NAME}: no such file; {3000 * 'choose '}"))
    assert len(text) <= MAX_SENTENCE
    assert max(map(len, text.split())) <= MAX_WORD
    assert text.startswith("xxx")
    assert str(PilegraspError("a short sentence")) == "a short sentence"


def test_control_characters_do_not_reach_the_terminal(capsys):
    err = refused(capsys, "run", "\x1b[2Jspheres\x07")
    assert r"\x1b[2Jspheres\x07" in err


# --- names in any encoding --------------------------------------------------------------------------------------------


def in_encoding(encoding, *arguments, cwd):
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONIOENCODING": encoding}
    command = [sys.executable, "-m", "pilegrasp_ctrl", *arguments]
    return subprocess.run(command, cwd=cwd, env=environment, capture_output=True, check=False)


@pytest.mark.parametrize(
    ("encoding", "printed"), [("ascii", b"\\xe9.html\n"), ("latin-1", b"\xe9.html\n"), ("utf-8", "é.html\n".encode())]
)
def test_a_name_is_printed_in_any_encoding(tmp_path, encoding, printed):
    synthetic(frames=3, objects=2).save(tmp_path / "a.npz")
    done = in_encoding(encoding, "export", "a.npz", "é.html", cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (0, printed, b"")
    assert (tmp_path / "é.html").stat().st_size > 0


def test_a_name_that_is_not_utf_8_is_printed_as_it_is(tmp_path):
    name = os.fsdecode(b"\xe9.html")
    synthetic(frames=3, objects=2).save(tmp_path / "a.npz")
    done = in_encoding("utf-8", "export", "a.npz", name, cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (0, b"\xe9.html\n", b"")
    assert (tmp_path / name).stat().st_size > 0


def test_a_text_that_is_not_unicode_is_named(capsys, tmp_path):
    name = os.fsdecode(b"gains\xe9.toml")
    assert "is not Unicode" in refused(capsys, "run", "push_wall", "--set", f"controller.gains={name}")
    (tmp_path / name).write_text("program = 'line'\n[pile]\ncount = 0\n")
    assert "is not Unicode" in refused(capsys, "run", tmp_path / name)
    assert (
        cli.main(["run", str(tmp_path / name), "--set", "name=e", "--set", "line.displacement=[0.0, 0.01, 0.0]"]) == 0
    )
