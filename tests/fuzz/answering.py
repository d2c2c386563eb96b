"""A process that answers questions: it imports the program once, and answers each question in a fork of itself.

So an answer costs milliseconds, may crash, hang or take all memory, and leaves no state for the next one.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from question import HOME, TEMPORARY, WORK, Answer, Question, snapshot

ACCEPTED = 77
"""Exit status of a fork whose attempt was ended on purpose."""

MEMORY_LIMIT = 6 << 30
"""Address space of an answer [bytes] (chosen): a program that wants more fails, and the machine goes on."""

MAX_FILE = 256 << 20
"""Largest file that an answer may write [bytes] (chosen)."""


class Responder:
    """The answering process, seen from outside; a context manager."""

    def __init__(self) -> None:
        here = Path(__file__).resolve()
        environment = os.environ | {
            "PYTHONPATH": os.pathsep.join(map(str, (here.parent, here.parents[1] / "helpers", here.parents[2])))
        }
        environment |= dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
        environment |= {"COLUMNS": "80", "NO_COLOR": "1"}
        environment.pop("FORCE_COLOR", None)
        self._process = subprocess.Popen(
            [sys.executable, str(here)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=environment,
            text=True,
        )
        self._folders = tempfile.TemporaryDirectory(prefix="fuzz-")
        self._number = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._process.stdin.close()  # type: ignore[union-attr]
        self._process.wait()
        self._folders.cleanup()

    def ask(self, question: Question) -> Answer:
        """Lay the files of a question out, ask it, and clear up."""
        self._number += 1
        folder = Path(self._folders.name) / str(self._number)
        try:
            question.lay(folder)
            before = snapshot(folder / WORK)
            reply = self._exchange(
                {
                    "folder": str(folder),
                    "call": list(question.call),
                    "stop_after": question.stop_after,
                    "patience": question.patience,
                }
            )
            after = snapshot(folder / WORK)
            changed = sorted(path for path in before.keys() | after.keys() if before.get(path) != after.get(path))
            parts = [path for path in after if path.endswith(".part")]
            left = sorted([*snapshot(folder / TEMPORARY), *parts])
            out, err = ((folder / name).read_text(encoding="utf-8", errors="replace") for name in ("out", "err"))
            return Answer(out=out, err=err, changed=tuple(changed), left=tuple(left), **reply)
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def _exchange(self, request: dict[str, Any]) -> dict[str, Any]:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(json.dumps(request) + "\n")
        self._process.stdin.flush()
        line = self._process.stdout.readline()
        if not line:
            raise RuntimeError("the answering process has ended")
        return dict(json.loads(line))


class Enough(BaseException):
    """The attempt has begun, so its input is accepted."""


def _serve() -> None:
    _prepare()
    base = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    channel = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    for line in sys.stdin:
        request = json.loads(line)
        patience = request.pop("patience")
        begin = time.monotonic()
        child = os.fork()
        if child == 0:
            os._exit(_answer(**request))
        status, usage = _wait(child, begin + patience)
        accepted = status == ACCEPTED
        reply = {
            "status": 0 if accepted else status,
            "accepted": accepted,
            "wall": time.monotonic() - begin,
            "processor": usage.ru_utime + usage.ru_stime,
            "memory": max(0, usage.ru_maxrss - base) << 10,
        }
        channel.write(json.dumps(reply) + "\n")
        channel.flush()


def _wait(child: int, deadline: float) -> tuple[int | None, Any]:
    pause = 1e-3
    while True:
        done, status, usage = os.wait4(child, os.WNOHANG)
        if done:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(child, signal.SIGKILL)  # workers that it left behind
            return os.waitstatus_to_exitcode(status), usage
        if time.monotonic() > deadline:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(child, signal.SIGKILL)
            _, _, usage = os.wait4(child, 0)
            return None, usage
        time.sleep(pause)
        pause = min(2.0 * pause, 0.02)


def _answer(folder: str, call: list[str], stop_after: int | None) -> int:
    """Answer in a fork, with streams, folders and limits of its own; return the exit status."""
    os.setsid()
    signal.signal(signal.SIGINT, signal.default_int_handler)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_LIMIT, MEMORY_LIMIT))
    resource.setrlimit(resource.RLIMIT_FSIZE, (MAX_FILE, MAX_FILE))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    os.environ |= {"HOME": f"{folder}/{HOME}", "TMPDIR": f"{folder}/{TEMPORARY}"}
    if (Path(folder) / HOME / ".cache").is_dir():
        os.environ["XDG_CACHE_HOME"] = f"{folder}/{HOME}/.cache"
    tempfile.tempdir = None
    os.chdir(f"{folder}/{WORK}")
    with open(os.devnull) as nothing, open(f"{folder}/out", "w") as out, open(f"{folder}/err", "w") as err:
        for number, stream in enumerate((nothing, out, err)):
            os.dup2(stream.fileno(), number)
        sys.stdin = open(0, closefd=False)  # noqa: SIM115
        sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
        sys.stderr = open(2, "w", encoding="utf-8", closefd=False, buffering=1)  # noqa: SIM115
        try:
            status = _call(call, stop_after)
        except Enough:
            status = ACCEPTED
        for stream in (sys.stdout, sys.stderr):
            with contextlib.suppress(OSError):
                stream.flush()
    return status


def _call(call: list[str], stop_after: int | None) -> int:
    if stop_after is not None:
        _end_attempts_after(stop_after)
    if not call or not call[0].startswith("@"):
        from pilegrasp_ctrl.cli import main

        return main(call)
    from calls import CALLS
    from pilegrasp_ctrl.cli.application import printable
    from pilegrasp_ctrl.exceptions import PilegraspError, shortened

    try:
        return CALLS[call[0][1:]](*call[1:]) or 0
    except PilegraspError as error:
        print(f"error: {printable(shortened(str(error)))}", file=sys.stderr)
        return 2
    except Exception as error:
        print(f"internal error ({type(error).__name__}: {error})", file=sys.stderr)
        return 1


def _prepare() -> None:
    """Import what answers need, and keep away what belongs to this machine: browsers, workers, long measurements."""
    import calls
    import pilegrasp_ctrl.analysis.motion
    import pilegrasp_ctrl.cli.program
    import pilegrasp_ctrl.episode
    import pilegrasp_ctrl.scenarios.paper.run
    import pilegrasp_ctrl.study.run
    import pilegrasp_ctrl.tuning.search
    import pilegrasp_ctrl.validation.bench.benchmark
    import pilegrasp_ctrl.viewer.page.document
    import pilegrasp_ctrl.viewer.pictures.chromium
    from pilegrasp_ctrl.study.dispatch import InlinePool

    def enough(*arguments: Any, **options: Any) -> Any:
        raise Enough

    pilegrasp_ctrl.viewer.pictures.chromium.find_chromium = lambda: None
    calls.real_pool = pilegrasp_ctrl.study.run.open_pool
    pilegrasp_ctrl.study.run.open_pool = lambda jobs, scheduler: InlinePool()
    pilegrasp_ctrl.validation.bench.benchmark.run_benchmark = enough
    pilegrasp_ctrl.tuning.search.run_search = enough
    _warm()


def _warm() -> None:
    """Answer some questions once, so that what is loaded on first use is there for all."""
    from file_inputs import recording_bytes
    from pilegrasp_ctrl.cli import main

    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
        recording = Path(folder) / "a.npz"
        recording.write_bytes(recording_bytes())
        for call in (["list"], ["export", str(recording), str(recording.with_suffix(".html"))]):
            if main(call) != 0:
                raise RuntimeError(f"{call} failed")


def _end_attempts_after(periods: int) -> None:
    """End every attempt after some control periods; what is wrong with its input has been said by then."""
    from pilegrasp_ctrl import episode

    run_attempt = episode.run_attempt

    def begin(attempt: Any, backend: Any = None, **options: Any) -> Any:
        left = periods

        def count(part: str) -> None:
            nonlocal left
            left -= part == "step"
            if left <= 0:
                raise Enough

        return run_attempt(attempt, backend, on_part=count, **options)

    episode.run_attempt = begin


if __name__ == "__main__":
    _serve()
