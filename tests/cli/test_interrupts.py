"""Ctrl-C, `kill` and a closed terminal: status 130, nothing printed, nothing left, from the first import on."""

import os
import signal
import subprocess
import sys
import time

import pytest

from pilegrasp_ctrl import cli
from pilegrasp_ctrl.cli import interrupts
from pilegrasp_ctrl.cli.interrupts import ENDING, INTERRUPTED, Interrupts
from places import ROOT

AT_AN_IMPORT = """
import os, signal, sys

class Sender:
    def find_spec(self, name, path=None, target=None):
        if name == module:
            sys.meta_path.remove(self)
            os.kill(os.getpid(), int(number))

number, module = sys.argv[1:3]
del sys.argv[1:3]
sys.meta_path.insert(0, Sender())
from pilegrasp_ctrl.cli import main
sys.exit(main())
"""
"""Program that gets a signal when it begins to import a module, and otherwise is `pilegrasp`."""


def interrupted_at(module, number, *arguments, cwd):
    command = [sys.executable, "-c", AT_AN_IMPORT, str(int(number)), module, *arguments]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "TMPDIR": str(cwd)}
    done = subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout, done.stderr


@pytest.mark.parametrize("number", ENDING)
@pytest.mark.parametrize("module", ["typer", "rich.progress", "pilegrasp_ctrl.cli.tune"])
def test_a_signal_while_the_command_line_is_imported_says_nothing(tmp_path, module, number):
    assert interrupted_at(module, number, "list", cwd=tmp_path) == (INTERRUPTED, "", "")


@pytest.mark.slow
@pytest.mark.parametrize("module", ["numpy", "pydantic", "pinocchio", "numba"])
def test_a_signal_while_engines_are_imported_says_nothing_and_leaves_nothing(tmp_path, module):
    arguments = ["run", "free_space_line", "--record", "a.npz", "--html", "a.html"]
    assert interrupted_at(module, signal.SIGINT, *arguments, cwd=tmp_path) == (INTERRUPTED, "", "")
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def quick(monkeypatch):
    monkeypatch.setattr(interrupts, "REPEAT_AFTER", 0.2)


def wait():
    for _ in range(200):
        time.sleep(0.01)


@pytest.mark.parametrize("number", ENDING)
def test_a_signal_interrupts_and_the_next_ones_do_not_disturb_the_cleaning_up(number):
    cleaned = False
    with Interrupts(at_once_in_the_end=False) as guard:
        guard.begin()
        try:
            os.kill(os.getpid(), number)
            wait()
        except KeyboardInterrupt:
            os.kill(os.getpid(), number)
            time.sleep(0.05)
            cleaned = True
        assert guard.received
    assert cleaned


def test_a_signal_that_comes_much_later_interrupts_again(quick):
    with Interrupts(at_once_in_the_end=False) as guard:
        guard.begin()
        for _ in range(2):
            with pytest.raises(KeyboardInterrupt):  # noqa: PT012
                os.kill(os.getpid(), signal.SIGINT)
                wait()
            time.sleep(0.25)


class Destroyed:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.01)


def test_an_interrupt_that_a_destructor_loses_is_raised_again(capfd):
    with Interrupts(at_once_in_the_end=False) as guard:
        guard.begin()
        with pytest.raises(KeyboardInterrupt):  # noqa: PT012
            Destroyed()
            wait()
    assert capfd.readouterr().err == ""


def test_a_signal_that_the_parent_ignores_stays_ignored():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with Interrupts(at_once_in_the_end=False):
            assert signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)


def test_a_call_from_python_gives_the_signals_back(capsys):
    before = [signal.getsignal(number) for number in ENDING]
    hook = sys.unraisablehook
    assert cli.main(["list"]) == 0
    assert [signal.getsignal(number) for number in ENDING] == before
    assert sys.unraisablehook is hook


def test_an_interrupt_that_a_library_turns_into_an_error_stays_an_interrupt(monkeypatch, capsys):
    def torn(*_, **__):
        try:
            os.kill(os.getpid(), signal.SIGINT)
            wait()
        except KeyboardInterrupt:
            raise ImportError("initialization failed") from None

    monkeypatch.setattr("pilegrasp_ctrl.scenarios.names", torn)
    assert cli.main(["list"]) == INTERRUPTED
    assert capsys.readouterr() == ("", "")


INSIDE_AN_EXEC = """
import os, signal, sys
from pilegrasp_ctrl.cli.interrupts import Interrupts

with Interrupts(True) as interrupts:
    try:
        interrupts.begin()
        exec("os.kill(os.getpid(), signal.SIGTERM); signal.pause()")
    except KeyboardInterrupt:
        pass
sys.exit(130)
"""


def test_an_interrupt_inside_an_exec_keeps_the_exit_status(tmp_path):
    (tmp_path / "program.py").write_text(INSIDE_AN_EXEC)
    environment = os.environ | {"PYTHONPATH": f"{ROOT}:{tmp_path}"}
    # Only `python -m` looks at the mark that the exec leaves.
    done = subprocess.run([sys.executable, "-m", "program"], env=environment, timeout=60, check=False)
    assert done.returncode == INTERRUPTED
