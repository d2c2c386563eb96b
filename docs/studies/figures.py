"""Measure the numbers of `docs/figures.toml` again and write them into the pages.

Usage: python docs/studies/figures.py [NAME]...; without a name, all of them
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from pilegrasp_ctrl.exceptions import ConfigurationError
from script import run_script

ROOT = Path(__file__).resolve().parents[2]
"""Folder of this checkout."""

DECLARED = ROOT / "docs" / "figures.toml"
"""File that declares the figures."""

QUICK = 30.0
"""Longest time of a figure that the tests measure again [s]; chosen."""


@dataclass(frozen=True, slots=True)
class Figure:
    """A number in a page; the attributes are the keys of `docs/figures.toml`."""

    name: str
    page: str
    value: list[Any]
    format: str
    tolerance: float
    seconds: float
    revision: str
    command: str | None = None
    file: str | None = None

    @property
    def anchor(self) -> re.Pattern[str]:
        """The place in the page; its group 1 is the text."""
        return re.compile(f"(?<=<!-- figure {re.escape(self.name)} -->)(.*?)(?=<!-- end -->)")

    def shown(self) -> str:
        """Return the text in the page.

        Raises:
            ConfigurationError: The page does not show the figure exactly once.
        """
        found = self.anchor.findall((ROOT / self.page).read_text(encoding="utf-8"))
        if len(found) != 1:
            raise ConfigurationError(f"{self.page}: shows the figure {self.name!r} {len(found)} times instead of once")
        return str(found[0])

    def measure(self) -> Any:
        """Return the number from the file, or from the output of the command.

        Raises:
            ConfigurationError: The command fails.
        """
        if self.file is not None:
            text = (ROOT / self.file).read_text(encoding="utf-8")
            return select(tomllib.loads(text) if self.file.endswith(".toml") else json.loads(text), self.value)
        # The command `pilegrasp` of this interpreter, even if its environment is not activated.
        path = os.pathsep.join((str(Path(sys.executable).parent), os.environ.get("PATH", "")))
        done = subprocess.run(
            self.command or "",
            shell=True,
            cwd=ROOT,
            env={**os.environ, "PATH": path},
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode:
            raise ConfigurationError(f"{self.command}: ended with status {done.returncode}: {done.stderr.strip()}")
        return select(json.loads(done.stdout), self.value)

    def text(self, number: Any) -> str:
        """Return a number as the page shows it."""
        return self.format.format(number).replace("%", " %")

    def agrees(self, number: Any) -> bool:
        """Return whether the page shows this number, up to the tolerance."""
        shown, text = self.shown(), self.text(number)
        if shown == text or not self.tolerance:
            return shown == text
        old, new = (float(re.search(r"-?\d+(\.\d+)?", words).group()) for words in (shown, text))  # type: ignore[union-attr]
        return abs(old - new) <= self.tolerance * abs(new)

    def write(self, number: Any) -> None:
        """Write the number into the page."""
        page = ROOT / self.page
        text = page.read_text(encoding="utf-8")
        page.write_text(self.anchor.sub(lambda _: self.text(number), text), encoding="utf-8")


def figures() -> list[Figure]:
    """Return the figures that `docs/figures.toml` declares."""
    known = {field.name for field in fields(Figure)}
    entries = tomllib.loads(DECLARED.read_text(encoding="utf-8"))["figure"]
    for entry in entries:
        if unknown := entry.keys() - known:
            raise ConfigurationError(f"{DECLARED}: a figure has no key {min(unknown)!r}; keys are {', '.join(known)}")
    return [Figure(**entry) for entry in entries]


def select(document: Any, path: list[Any]) -> Any:
    """Return the entry of a document: a key, an index, or a table that an entry of a list must match."""
    for part in path:
        if isinstance(part, Mapping):
            document = next(entry for entry in document if part.items() <= entry.items())
        else:
            document = document[part]
    return document


def main(*names: str) -> None:
    """Measure the figures of these NAMES, or all, and write them into their pages."""
    chosen = [figure for figure in figures() if not names or figure.name in names]
    for figure in chosen:
        number = figure.measure()
        before = figure.shown()
        figure.write(number)
        change = "" if figure.shown() == before else f" (was {before})"
        print(f"{figure.page}: {figure.name} = {figure.shown()}{change}", file=sys.stderr)


if __name__ == "__main__":
    run_script(main)
