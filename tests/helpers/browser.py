"""The viewer's Chromium with the tools of a test: the requests, console errors and picture of a page."""

from __future__ import annotations

import json
import stat
from pathlib import Path
from typing import Any

from pilegrasp_ctrl.viewer.pictures.chromium import Chromium, find_chromium

__all__ = ["Browser", "find_chromium", "program"]


class Browser(Chromium):
    """A browser that records the requests and the console errors of its page."""

    def visit(self, url: str, width: int = 1280, height: int = 800) -> None:
        """Load a page from a server, with the network on."""
        self.call(
            "Network.emulateNetworkConditions", offline=False, latency=0, downloadThroughput=-1, uploadThroughput=-1
        )
        self.events.clear()
        self.resize(width, height)
        self.call("Page.navigate", url=url)
        self.wait_for("document.readyState === 'complete'")

    def _named(self, method: str) -> list[dict[str, Any]]:
        return [event["params"] for event in self.events if event["method"] == method]

    def requests(self) -> list[str]:
        """Return every address that the page has requested since it was opened."""
        return [event["request"]["url"] for event in self._named("Network.requestWillBeSent")]

    def console_errors(self) -> list[str]:
        """Return the errors and warnings in the console, uncaught exceptions included."""
        console = [
            " ".join(str(argument.get("value", argument.get("description"))) for argument in event["args"])
            for event in self._named("Runtime.consoleAPICalled")
            if event["type"] in ("error", "warning", "assert")
        ]
        thrown = [json.dumps(event["exceptionDetails"]) for event in self._named("Runtime.exceptionThrown")]
        logged = [
            event["entry"]["text"]
            for event in self._named("Log.entryAdded")
            if event["entry"]["level"] in ("error", "warning")
        ]
        return console + thrown + logged


def program(folder: Path, name: str, text: str) -> Path:
    """Write a script that replaces a program, and return its path."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return path
