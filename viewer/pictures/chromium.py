"""A headless Chromium, driven over the DevTools protocol through two pipes with the standard library alone."""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Self

from pilegrasp_ctrl.exceptions import ExportError
from pilegrasp_ctrl.interruption import signals_wait

NAMES = ("chromium", "chromium-browser", "google-chrome-stable", "google-chrome", "chrome")
"""Usual names of the program on the PATH, the preferred one first."""

MAC_PROGRAM = "/Applications/{0}.app/Contents/MacOS/{0}"
"""Path of the program on macOS, by the name of its bundle."""

FLAGS = (
    "--headless=new",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-extensions",
    "--disable-dev-shm-usage",
    "--hide-scrollbars",
    "--remote-debugging-pipe",
)
"""Flags of every start: no window, software rendering, no background traffic, and commands through pipes."""

NO_SANDBOX = "--no-sandbox"
"""Flag for root, for whom Chromium does not start with its sandbox. Everybody else keeps the sandbox. The browser opens
only pages that this program has written, and its tab is offline."""

REPLACED = ("navigated or closed", "context was destroyed", "Cannot find context", "Cannot find default execution")
"""Parts of the browser's messages that mean: another page took the place of the one that was asked."""

CLOSING_TIME = 3.0
"""Longest time in which the browser may answer the request to end [s]; chosen. Then it is killed."""

REMOVALS, REMOVAL_PAUSE = 50, 0.02
"""Number of trials to remove a profile in which a dying helper still writes, and the time between them [s]; chosen."""

LAUNCH = (
    "import os, sys; [os.dup2(int(n), k) for n, k in zip(sys.argv[1:], (3, 4))]; os.execv(sys.argv[3], sys.argv[3:])"
)
"""Python program that starts Chromium with its pipes in place: commands on descriptor 3, answers on 4."""


class PageReplacedError(ExportError):
    """Another page took the place of the one that was asked, before it answered."""


def find_chromium() -> str | None:
    """Return the browser named by PILEGRASP_CHROMIUM or the first of the usual names on the path."""
    bundles = (MAC_PROGRAM.format(name) for name in ("Google Chrome", "Chromium"))
    return os.environ.get("PILEGRASP_CHROMIUM") or next(filter(None, map(shutil.which, (*NAMES, *bundles))), None)


def require_chromium() -> str:
    """Return the path of a browser that can draw.

    Raises:
        ExportError: No browser is found, or PILEGRASP_CHROMIUM names no program.
    """
    named = os.environ.get("PILEGRASP_CHROMIUM")
    if named and not shutil.which(named):
        raise ExportError(f"PILEGRASP_CHROMIUM names {named!r}, which is not a program; name a Chromium or unset it")
    found = find_chromium()
    if found is None:
        raise ExportError(
            "pictures are drawn by Chromium, which was not found; install it (on Debian `apt-get install chromium`), "
            "or name a Chromium or Chrome in PILEGRASP_CHROMIUM; an .html page needs neither"
        )
    return shutil.which(found) or found


def _sandbox_flags() -> tuple[str, ...]:
    return (NO_SANDBOX,) if os.geteuid() == 0 else ()


class Chromium:
    """One browser process with one tab, offline from the first moment; a context manager that leaves no process.

    Attributes:
        executable: Path of the browser.
        timeout: Longest time to wait for an answer [s].
        events: Reports of the browser since the last page was opened, in the protocol's form.

    Raises:
        ExportError: The program cannot be started, ends, or does not answer for `timeout` [s].
    """

    def __init__(self, executable: str, *flags: str, timeout: float = 60.0) -> None:
        self.timeout = timeout
        self.events: list[dict[str, Any]] = []
        self.executable = executable
        self._buffer = b""
        self._count = 0
        self._session: str | None = None
        self._profile = ""
        self._process: subprocess.Popen[bytes] | None = None
        try:
            # A browser whose start is interrupted would go on without an owner.
            with signals_wait():
                self._start(flags)
            self._attach()
        except BaseException:
            self.close()
            raise

    def _start(self, flags: tuple[str, ...]) -> None:
        self._profile = tempfile.mkdtemp(prefix="chromium-")
        to_browser, self._out = os.pipe()
        self._in, from_browser = os.pipe()
        command = [
            os.path.abspath(self.executable),
            *FLAGS,
            *_sandbox_flags(),
            *flags,
            f"--user-data-dir={self._profile}",
            "about:blank",
        ]
        # Descriptors from 10 on: moving one end to 3 or 4 must not close the other.
        ends = [fcntl.fcntl(end, fcntl.F_DUPFD, 10) for end in (to_browser, from_browser)]
        self._process = subprocess.Popen(
            [sys.executable, "-I", "-S", "-c", LAUNCH, *map(str, ends), *command],
            pass_fds=ends,
            # What a killed browser leaves in its temporary folder goes with the profile. The path is relative, because
            # that of a socket may have 107 letters only.
            cwd=self._profile,
            env=os.environ | {"TMPDIR": "."},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            # An interrupt from the keyboard reaches this program only, which then closes the browser in order.
            start_new_session=True,
        )
        for end in (to_browser, from_browser, *ends):
            os.close(end)

    def _attach(self) -> None:
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        self.call(
            "Network.emulateNetworkConditions", offline=True, latency=0, downloadThroughput=-1, uploadThroughput=-1
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the browser with all its processes, and remove its profile; signals wait until then."""
        with signals_wait():
            self._end()

    def _end(self) -> None:
        if self._process is None:
            shutil.rmtree(self._profile, ignore_errors=True)
            return
        with contextlib.suppress(OSError, ExportError, subprocess.TimeoutExpired):
            self._session = None
            self.timeout = min(self.timeout, CLOSING_TIME)
            self.call("Browser.close")
            self._process.wait(CLOSING_TIME)
        # Helpers of the browser may outlive it and write to the profile. Its session holds nobody else.
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        for end in (self._out, self._in):
            os.close(end)
        for _ in range(REMOVALS):
            shutil.rmtree(self._profile, ignore_errors=True)
            if not os.path.lexists(self._profile):
                break
            time.sleep(REMOVAL_PAUSE)

    def _receive(self) -> dict[str, Any]:
        while b"\0" not in self._buffer:
            if not select.select([self._in], [], [], self.timeout)[0]:
                raise ExportError(f"the browser {self.executable} does not answer for {self.timeout:.0f} s; try again")
            block = os.read(self._in, 1 << 20)
            if not block:
                sandboxed = (
                    "" if _sandbox_flags() else " (its sandbox needs user namespaces, which some containers lack)"
                )
                raise ExportError(
                    f"the browser {self.executable} ended by itself; see whether it starts with --headless{sandboxed}, "
                    "or name another in PILEGRASP_CHROMIUM"
                )
            self._buffer += block
        message, self._buffer = self._buffer.split(b"\0", 1)
        result: dict[str, Any] = json.loads(message)
        return result

    def _send(self, message: dict[str, Any]) -> None:
        content = json.dumps(message).encode() + b"\0"
        try:
            while content:
                content = content[os.write(self._out, content) :]
        except BrokenPipeError:
            # `_receive` reads the last answers of the program, and raises the error.
            pass

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Send one command of the protocol and return its result; keep the events that arrive meanwhile.

        Raises:
            ExportError: The browser refuses the command, ends, or does not answer.
        """
        self._count += 1
        message: dict[str, Any] = {"id": self._count, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        self._send(message)
        while True:
            answer = self._receive()
            if "method" in answer:
                self.events.append(answer)
            elif answer.get("id") == self._count:
                if "error" in answer:
                    reason = answer["error"].get("message", "")
                    error = PageReplacedError if any(words in reason for words in REPLACED) else ExportError
                    raise error(f"the browser refuses {method}: {reason}")
                result: dict[str, Any] = answer["result"]
                return result

    def evaluate(self, script: str) -> Any:
        """Return the JSON value of an expression in the page; a promise is awaited.

        Raises:
            ExportError: The expression throws.
        """
        answer = self.call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            raise ExportError(f"the page's script failed: {json.dumps(answer['exceptionDetails'])}")
        return answer["result"].get("value")

    def open(self, file: Path, width: int = 1280, height: int = 800) -> None:
        """Load a file at a window size [px] and wait until it has loaded and drawn."""
        self.events.clear()
        self.resize(width, height)
        failure = self.call("Page.navigate", url=file.resolve().as_uri()).get("errorText")
        if failure:
            raise ExportError(f"the browser {self.executable} cannot open {file}: {failure}")
        self.wait_for("document.readyState === 'complete'")
        self.wait_for_picture()

    def resize(self, width: int, height: int, dark: bool = False) -> None:
        """Give the window a size [px] and a colour scheme."""
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.call("Emulation.setEmulatedMedia", features=[scheme])

    def wait_for_picture(self) -> None:
        """Return after the next frame has been drawn."""
        self.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")

    def wait_for(self, condition: str) -> None:
        """Return when the expression is true in the page.

        Raises:
            ExportError: The expression stays false for `timeout`.
        """
        limit = time.monotonic() + self.timeout
        while not self._is_true(condition):
            if time.monotonic() > limit:
                raise ExportError(f"the page never reached: {condition}")
            time.sleep(0.02)

    def _is_true(self, condition: str) -> bool:
        """Return whether the expression is true; False while another page takes the place of this one."""
        try:
            return bool(self.evaluate(condition))
        except PageReplacedError:
            return False
