"""Links from the documentation to lines of code: `[text](../file.py#L12 "code on that line")`.

`python tests/helpers/line_links.py` updates the line numbers after the code has moved.
"""

import re
from pathlib import Path
from typing import NamedTuple

from places import ROOT

PATTERN = re.compile(r'\]\((?P<target>[^()\s#]+)#L(?P<line>\d+) "(?P<text>[^"]+)"\)')


class LineLink(NamedTuple):
    """A link to a line, and the code of that line in the link's title."""

    file: Path
    line: int
    text: str

    def found(self) -> list[int]:
        """Return the lines of the file that hold the code."""
        lines = self.file.read_text(encoding="utf-8").splitlines()
        return [number for number, line in enumerate(lines, 1) if self.text in line]


def line_links(page: Path) -> list[LineLink]:
    """Return the links of a page that name a line."""
    text = page.read_text(encoding="utf-8")
    return [_link(page, match) for match in PATTERN.finditer(text)]


def _link(page: Path, match: re.Match) -> LineLink:
    return LineLink((page.parent / match["target"]).resolve(), int(match["line"]), match["text"])


def renumbered(page: Path) -> str:
    """Return the page's text with the present line numbers of the code."""

    def renumber(match: re.Match) -> str:
        lines = _link(page, match).found()
        if len(lines) != 1:
            raise SystemExit(f"{page.name}: {match['text']!r} is on {len(lines)} lines of {match['target']}")
        return f']({match["target"]}#L{lines[0]} "{match["text"]}")'

    return PATTERN.sub(renumber, page.read_text(encoding="utf-8"))


if __name__ == "__main__":
    for document in sorted((ROOT / "docs").glob("**/*.md")):
        document.write_text(renumbered(document), encoding="utf-8")
