"""Signals at drawn moments: a command that is interrupted, told to end, or killed leaves nothing half-done behind."""

from __future__ import annotations

import contextlib
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from file_inputs import recording_bytes
from pilegrasp_ctrl.exceptions import PilegraspError
from pilegrasp_ctrl.recording import Recording
from places import ROOT
from processes import is_there, members

SIGNALS = (signal.SIGINT, signal.SIGINT, signal.SIGTERM, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL)
"""Signals that are drawn from."""

MAX_END = 15.0
"""Longest time from a signal to the end of the command [s] (chosen)."""

INTERRUPTED = 130
"""Exit status of a command that a signal ends in order."""

FIRST_MOMENT = 0.05
"""Earliest moment of a signal [s] (chosen): before, no line of the program has run."""

_LINE = ("--set", "line.displacement=[0.0, 0.02, 0.0]")
COMMANDS: dict[str, tuple[str, ...]] = {
    "list": ("list", "--json"),
    "run": ("run", "free_space_line", *_LINE, "--record", "a.npz", "--html", "a.html", "--json"),
    "export": ("export", "b.npz", "b.html"),
    "picture": ("export", "b.npz", "b.png"),
    "movie": ("export", "b.npz", "b.gif"),
    "sweep": (
        *("sweep", "free_space_line", *_LINE, "--vary", "line.speed=0.2,0.3", "--seeds", "0:3", "--jobs", "2"),
        *("--record", "all", "--out", "study", "--json"),
    ),
    "tune": ("tune", "free_space_line", *_LINE, "--trials", "2", "--out", "search", "--json"),
}
"""Commands that are interrupted, by name."""

RESUMED = ("sweep", "tune")
"""Commands that go on when they are repeated."""


@dataclass(frozen=True, slots=True)
class Trial:
    """What was done: a command, a signal, and its moment [s]."""

    command: str
    signal: signal.Signals
    moment: float


def trials(seed: int) -> Iterator[Trial]:
    """Yield trials without end; half of the moments lie in the first second, where imports are."""
    draw = random.Random(seed)
    names = [name for name in COMMANDS if name not in ("picture", "movie") or _has_browser()]
    while True:
        name = draw.choice(names)
        latest = draw.choice((min(1.0, duration(name)), duration(name)))
        yield Trial(name, draw.choice(SIGNALS), draw.uniform(FIRST_MOMENT, max(2.0 * FIRST_MOMENT, latest)))


def _has_browser() -> bool:
    from pilegrasp_ctrl.viewer.pictures.chromium import find_chromium

    return find_chromium() is not None


@cache
def duration(name: str) -> float:
    """Return how long a command takes if nobody disturbs it [s]."""
    with _folder() as folder:
        begin = time.monotonic()
        process = _begin(name, folder)
        _, err = process.communicate()
        if process.returncode != 0:
            raise AssertionError(f"{COMMANDS[name]} ended with {process.returncode}: {err}")
        return time.monotonic() - begin


@contextlib.contextmanager
def _folder() -> Iterator[Path]:
    with tempfile.TemporaryDirectory(prefix="signal-") as name:
        folder = Path(name)
        for part in ("work", "tmp"):
            (folder / part).mkdir()
        (folder / "work" / "b.npz").write_bytes(recording_bytes())
        yield folder


def _begin(name: str, folder: Path) -> subprocess.Popen[str]:
    environment = os.environ | {"PYTHONPATH": str(ROOT), "TMPDIR": str(folder / "tmp")}
    return subprocess.Popen(
        [sys.executable, "-m", "pilegrasp_ctrl", *COMMANDS[name]],
        cwd=folder / "work",
        env=environment,
        # In its own process group a Ctrl-C reaches the workers too, as in a terminal.
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def fault_of_trial(trial: Trial) -> str | None:
    """Disturb a command and return what is wrong with its end, or None if it is well.

    Well is: status 130, or the signal's own end where no line of the program has run; no traceback, no process and no
    temporary file left, each output absent or whole, and a study or search that the same command finishes.
    """
    with _folder() as folder:
        process = _begin(trial.command, folder)
        time.sleep(trial.moment)
        ended_before = process.poll() is not None
        with contextlib.suppress(ProcessLookupError):
            if trial.signal == signal.SIGINT:
                os.killpg(process.pid, trial.signal)
            else:
                process.send_signal(trial.signal)
        try:
            out, err = process.communicate(timeout=MAX_END)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()
            return f"it did not end within {MAX_END:.0f} s"
        fault = _fault_of_end(trial, process.returncode, out, err, ended_before)
        fault = fault or _fault_of_processes(process.pid) or _fault_of_files(trial, folder)
        if fault is None and trial.command in RESUMED:
            again = _begin(trial.command, folder)
            _, err = again.communicate()
            if again.returncode != 0:
                return f"the same command then ends with {again.returncode}: {err[-300:]}"
        return fault


def _fault_of_end(trial: Trial, status: int, out: str, err: str, ended_before: bool) -> str | None:
    if "KeyboardInterrupt" in err and "pilegrasp_ctrl/cli" not in err:
        return None  # Python was still starting: no frame of its traceback is the command line's
    expected = (-trial.signal,) if trial.signal == signal.SIGKILL else (INTERRUPTED, -trial.signal)
    if status == 0 and (ended_before or out or err == ""):
        return None  # it was faster
    if status not in expected:
        return f"status {status}: {err[-300:]}"
    lines = [line for line in err.splitlines() if not line.startswith(("stopped; finished", "pilegrasp compiles"))]
    return f"on standard error: {err[-400:]!r}" if lines else None


def _fault_of_processes(group: int) -> str | None:
    deadline = time.monotonic() + 10.0
    while time.monotonic() < deadline:
        left = [number for number in members(group) if is_there(number)]
        if not left:
            return None
        time.sleep(0.05)
    os.killpg(group, signal.SIGKILL)
    return f"{len(left)} processes are left"


def _fault_of_files(trial: Trial, folder: Path) -> str | None:
    parts = [str(path.relative_to(folder)) for path in (folder / "work").rglob("*.part")]
    temporary = [path.name for path in (folder / "tmp").iterdir()]
    if trial.signal != signal.SIGKILL and (parts or temporary):
        return f"left behind: {', '.join([*parts, *temporary])}"
    for path in (folder / "work").rglob("*"):
        if path.suffix == ".html" and not path.read_text().rstrip().endswith("</html>"):
            return f"{path.name} is not whole"
        if path.suffix == ".npz":
            try:
                Recording.load(path)
            except PilegraspError as error:
                return f"{path.name} is not whole: {error}"
    shutil.rmtree(folder / "tmp")
    (folder / "tmp").mkdir()
    return None
