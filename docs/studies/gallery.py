"""Run the attempts of docs/gallery.toml, take their pictures, and write docs/gallery.md.

Usage: python docs/studies/gallery.py [FOLDER]

FOLDER gets the page of every attempt, NAME.html; `build/gallery` if it is not given. Or: make gallery
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from textwrap import fill
from typing import Any

from PIL import Image

import pilegrasp_ctrl as pg
from pilegrasp_ctrl.viewer import write
from script import run_script

DOCS = Path(__file__).parents[1]
"""Folder of the pages."""

PICTURES = DOCS / "pictures" / "gallery"
"""Folder of the pictures."""

WIDTH, QUALITY = 640, 80
"""Width [px] and JPEG quality of a picture; chosen for a page of twelve."""

HEAD = """# Gallery

Twelve attempts. Each command makes a page that opens in any browser, offline; the line below it says what to expect.
`make gallery` runs them all, takes the pictures and writes this page.
"""


@dataclass(frozen=True, slots=True)
class Attempt:
    """One attempt of the gallery, as its TOML states it."""

    name: str
    title: str
    scenario: str
    seed: int
    set: Mapping[str, Any] = field(default_factory=dict)

    @property
    def command(self) -> str:
        """The command that makes its page."""
        keys = "".join(f" --set {key}={value}" for key, value in self.set.items())
        return f"pilegrasp run {self.scenario} --seed {self.seed}{keys} --html {self.name}.html"


def attempts() -> Iterator[Attempt]:
    """Yield the attempts of the gallery."""
    table = tomllib.loads((DOCS / "gallery.toml").read_text(encoding="utf-8"))
    yield from (Attempt(**entry) for entry in table["attempt"])


def section(attempt: Attempt, expected: str) -> str:
    """Return the part of the page about an attempt."""
    return (
        f"## {attempt.title}\n\n![{attempt.title}](pictures/gallery/{attempt.name}.jpg)\n\n"
        f"```bash\n{attempt.command}\n```\n\n{fill(expected, 110)}\n"
    )


def expected(result: Mapping[str, Any], recording: pg.Recording) -> str:
    """Return in a sentence how an attempt or an order ended."""
    if "attempts" in result:
        delivered = sum(attempt["delivered"] for attempt in result["attempts"])
        return f"Expect {delivered} delivered after {len(result['attempts'])} attempts."
    peak = float(recording.signals["push_force"].max())
    ends = f"{result['grasped']} held" if result["success"] else f"nothing held ({result['reason']})"
    return f"Expect {ends} after {result['sim_time']:.1f} s, and {peak:.1f} N at most against the push."


def main(folder: Path = Path("build/gallery")) -> None:
    """Run every attempt, and write pages, pictures and the gallery."""
    folder.mkdir(parents=True, exist_ok=True)
    PICTURES.mkdir(parents=True, exist_ok=True)
    parts = []
    for attempt in attempts():
        result = pg.run(attempt.scenario, seed=attempt.seed, overrides=attempt.set, record=True)
        sheet = folder / f"{attempt.name}.png"
        write(result.recording, folder / f"{attempt.name}.html")
        write(result.recording, sheet)
        with Image.open(sheet) as picture:
            small = picture.convert("RGB").resize((WIDTH, round(WIDTH * picture.height / picture.width)))
        small.save(PICTURES / f"{attempt.name}.jpg", quality=QUALITY, optimize=True)
        parts.append(section(attempt, expected(result.as_dict(), result.recording)))
        print(parts[-1])
    (DOCS / "gallery.md").write_text("\n".join([HEAD, *parts]), encoding="utf-8")


if __name__ == "__main__":
    run_script(main)
