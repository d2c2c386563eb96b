"""What users of command lines expect: examples in every help, completion, whole names, progress in logs, one logger."""

import json
import logging
import os
import shlex
import subprocess
import sys
import time
import tomllib

import pytest
import typer
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn

import pilegrasp_ctrl as pg
from pilegrasp_ctrl.cli import app, main, progress
from pilegrasp_ctrl.cli.completion import complete_scenario, complete_setting
from pilegrasp_ctrl.cli.paper import _print_claims
from pilegrasp_ctrl.cli.schema import schema_text
from pilegrasp_ctrl.config import dotted_keys
from places import ROOT
from synthetic_recording import synthetic

COMMANDS = typer.main.get_command(app).commands


def run(*arguments, **variables):
    """Run the command line in a process of its own."""
    command = [sys.executable, "-m", "pilegrasp_ctrl", *arguments]
    environment = os.environ | {"PYTHONPATH": str(ROOT)} | variables
    return subprocess.run(command, env=environment, capture_output=True, text=True)


@pytest.mark.parametrize("verb", COMMANDS)
def test_every_help_ends_with_examples_that_parse(verb):
    examples = [line.strip("-` ") for line in COMMANDS[verb].epilog.split("\n\n") if line.startswith("- ")]
    assert examples
    for example in examples:
        program, named, *arguments = shlex.split(example.partition(" > ")[0])
        assert (program, named) == ("pilegrasp", verb)
        if "--schema" not in arguments:
            COMMANDS[verb].make_context(verb, arguments)


@pytest.mark.parametrize("verb", COMMANDS)
def test_no_name_is_cut_off_in_a_help_of_80_columns(verb, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    assert main([verb, "--help"]) == 0
    out = capsys.readouterr().out
    assert "…" not in out
    for parameter in COMMANDS[verb].params:
        for option in parameter.opts if parameter.param_type_name == "option" else ():
            assert option in out


def test_list_keeps_names_whole_on_a_narrow_terminal(capsys, monkeypatch):
    monkeypatch.setattr("pilegrasp_ctrl.cli.application.MIN_WIDTH", 30)
    monkeypatch.setenv("COLUMNS", "30")
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TTY_COMPATIBLE", "1")
    assert main(["list"]) == 0
    assert "free_space_line" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("pilegrasp sw", {"sweep"}),
        ("pilegrasp run spheres_", {"spheres_alone", "spheres_corner", "spheres_wall"}),
        ("pilegrasp run spheres_wall --set strategy.grasp", {"strategy.grasp_force="}),
    ],
)
def test_the_tab_key_completes(words, expected):
    count = str(len(words.split()) - 1)
    done = run(_PILEGRASP_COMPLETE="complete_bash", COMP_WORDS=words, COMP_CWORD=count)
    assert set(done.stdout.split()) == expected


def test_completion_can_be_installed(tmp_path):
    # Without a shell among its parents, as in a scheduler, typer would find none.
    named = {"_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION": "1"}
    done = run("--install-completion", "bash", HOME=str(tmp_path), **named)
    assert done.returncode == 0, done.stderr
    assert "pilegrasp" in (tmp_path / ".bash_completions" / "pilegrasp.sh").read_text()


def test_files_and_folders_are_offered_beside_names(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "spheres").mkdir()
    (tmp_path / "spheres.toml").touch()
    (tmp_path / "spheres.txt").touch()
    assert complete_scenario("spheres") == [
        "spheres_alone",
        "spheres_corner",
        "spheres_wall",
        "spheres.toml",
        "spheres/",
    ]
    assert complete_setting("") == [f"{key}=" for key in dotted_keys()]


def test_outside_a_terminal_a_line_tells_progress_now_and_then(capsys, monkeypatch):
    now = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    with progress.make_progress(TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn()) as bar:
        line = bar.add_task("counting", total=4)
        for done in range(5):
            now[0] = 12.0 * done
            bar.update(line, completed=done)
    assert capsys.readouterr().err == "counting 3/4\n"


def test_the_library_notes_under_one_logger(caplog):
    with caplog.at_level(logging.INFO, "pilegrasp_ctrl"):
        pg.run("free_space_line")
    assert ("pilegrasp_ctrl.programs.attempt", logging.INFO, "free_space_line, seed 0: 0 objects are at rest") in (
        caplog.record_tuples
    )


def test_the_environment_shows_the_notes():
    done = run("run", "free_space_line", "--json", PILEGRASP_LOG="info")
    assert json.loads(done.stdout)["success"]
    assert "pilegrasp_ctrl.programs.attempt INFO: free_space_line" in done.stderr
    wrong = run("list", PILEGRASP_LOG="loud")
    assert (wrong.returncode, wrong.stderr.count("\n")) == (2, 1)
    assert "debug, info, warning, error" in wrong.stderr


@pytest.mark.parametrize("name", ["part.stl", "./part.obj", "light_sphere+part.STL"])
def test_a_mesh_in_the_place_of_an_object_says_which_lines_to_write(name, capsys):
    assert main(["run", "spheres_wall", "--set", f"pile.object={name}"]) == 2
    error = capsys.readouterr().err
    for line in ('shape = "mesh"', 'file = "part.', 'unit = "mm"', "mass = 0.1", "friction.lateral = 0.3", "part.toml"):
        assert line in error


def test_the_lines_that_a_mesh_needs_make_an_object(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    corners = "v 0 0 0\nv 40 0 0\nv 0 40 0\nv 0 0 40\n"
    (tmp_path / "part.obj").write_text(f"{corners}f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    main(["run", "spheres_wall", "--set", "pile.object=part.obj"])
    lines = capsys.readouterr().err.split("`")[1::2]
    (tmp_path / "part.toml").write_text("\n".join(lines))
    assert main(["check", "part.toml", "--json"]) == 0


def test_the_schema_that_ships_is_that_of_the_code_and_needs_no_scenario(capsys):
    assert main(["show", "--schema"]) == 0
    out = capsys.readouterr().out
    assert out == schema_text()
    shipped = (ROOT / "scenarios" / "scenario.schema.json").read_text(encoding="utf-8")
    assert shipped == out, "run `make schema`"
    assert '"null"' not in out


def test_the_schema_accepts_every_shipped_scenario_and_finds_a_wrong_key():
    jsonschema = pytest.importorskip("jsonschema")
    validator = jsonschema.Draft202012Validator(json.loads(schema_text()))
    for table in shipped_scenarios():
        assert list(validator.iter_errors(table)) == []
    assert list(validator.iter_errors({"pile": {"cuont": 5}}))
    assert list(validator.iter_errors({"strategy": {"theta_deg": 91.0}}))


def shipped_scenarios():
    """Return the tables of all shipped scenarios."""
    return [tomllib.loads(file.read_text(encoding="utf-8")) for file in (ROOT / "scenarios").glob("*.toml")]


def test_signals_become_a_table_of_pandas():
    recording = synthetic()
    table = recording.to_dataframe()
    assert len(table) == len(recording.signal_time)
    assert table.index.name == "time"
    for name, values in recording.signals.items():
        columns = [name] if values.ndim == 1 else [f"{name}[{k}]" for k in range(values.shape[1])]
        assert (table[columns].to_numpy().reshape(values.shape) == values).all()


def test_without_pandas_one_sentence_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(pg.RecordingError, match=r"pip install pilegrasp\[pandas\]"):
        synthetic().to_dataframe()


def test_paper_names_what_it_drew_and_judged(capsys, tmp_path):
    counted = {"n": 10}
    rows = [
        {"id": "C4", "verdict": None, "repeats": None, "claim": "a", "conditions": {"x": counted},
         "parts": [{"statement": "8 of 10 against 5 of 10"}]},
        {"id": "C5", "verdict": None, "repeats": None, "claim": "b", "conditions": {"y": {"n": 0}}, "parts": []},
    ]  # fmt: skip
    document = {"claims": rows, "nulls": [], "missing": 7, "figures": {"fig08": ["figures/fig08.svg"], "fig09": ["no"]}}
    _print_claims(document, tmp_path, ["fig08"])
    out = capsys.readouterr().out
    assert "C4: 8 of 10 against 5 of 10" in out
    assert "C5" not in out
    assert f"wrote {tmp_path}/figures/fig08.svg" in out
    assert "fig09" not in out
    _print_claims(document, tmp_path, [])
    assert "C5" in capsys.readouterr().out
