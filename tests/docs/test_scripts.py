"""The scripts in docs/studies: their usage, and their errors for wrong arguments."""

import runpy
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from pilegrasp_ctrl.exceptions import ConfigurationError
from places import STUDIES
from script import run_script, seed_range

FOLDER = STUDIES


def call(main, monkeypatch, *arguments):
    monkeypatch.setattr(sys, "argv", ["script.py", *arguments])
    run_script(main)


def takes(first: int, folder: Path = Path("."), *rest: str) -> None:
    """Take them."""
    takes.last = (first, folder, rest)


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["3"], (3, Path("."), ())),
        (["3", "a"], (3, Path("a"), ())),
        (["3", "a", "x=1", "y=2"], (3, Path("a"), ("x=1", "y=2"))),
    ],
)
def test_arguments_come_in_the_order_of_the_parameters(arguments, expected, monkeypatch):
    call(takes, monkeypatch, *arguments)
    assert takes.last == expected


def refuses(error):
    def main() -> None:
        """Fail."""
        raise error

    return main


@pytest.mark.parametrize(
    ("main", "arguments", "words"),
    [
        (takes, [], "required: first"),
        (takes, ["x"], "argument first: invalid int value: 'x'"),
        (refuses(ConfigurationError("no such key; leave it out")), [], "error: no such key; leave it out"),
        (refuses(FileNotFoundError(2, "No such file or directory", "a.json")), [], "error: a.json: No such file"),
        (refuses(ValueError("a defect")), ["more"], "unrecognized arguments: more"),
    ],
)
def test_a_wrong_argument_is_one_sentence_and_status_2(main, arguments, words, monkeypatch, capsys):
    with pytest.raises(SystemExit) as ended:
        call(main, monkeypatch, *arguments)
    assert ended.value.code == 2
    assert words in capsys.readouterr().err


@pytest.mark.parametrize("error", [ValueError("a defect"), OSError(32, "Broken pipe")])
def test_a_defect_keeps_its_traceback(error, monkeypatch):
    with pytest.raises(type(error)):
        call(refuses(error), monkeypatch)


@pytest.mark.slow
@pytest.mark.parametrize(
    "script", sorted(path.name for path in FOLDER.glob("*.py") if '__name__ == "__main__"' in path.read_text())
)
def test_every_script_prints_its_usage(script, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", [script, "--help"])
    with pytest.raises(SystemExit) as ended:
        runpy.run_path(str(FOLDER / script), run_name="__main__")
    shown = capsys.readouterr()
    assert not ended.value.code, shown.err
    assert "usage: " + script in shown.out
    assert f"python docs/studies/{script}" in (FOLDER / script).read_text().split('"""')[1]


@pytest.mark.skipif(find_spec("pybullet") is not None, reason="PyBullet is installed")
def test_without_pybullet_the_comparison_says_how_to_get_it():
    shown = subprocess.run(
        [sys.executable, FOLDER / "compare_pybullet.py"], capture_output=True, text=True, timeout=120
    )
    assert shown.returncode == 2
    assert shown.stderr.startswith("error: PyBullet is not installed")


@pytest.mark.parametrize("last", [3, 0])
def test_a_range_without_a_seed_is_refused(last):
    assert seed_range(3, 5) == range(3, 5)
    with pytest.raises(ConfigurationError, match=f"the range from 3 to {last} holds no seed"):
        seed_range(3, last)
