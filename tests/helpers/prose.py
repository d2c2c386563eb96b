"""Words, sentence lengths and long lines of the Markdown pages: `python tests/helpers/prose.py [PAGE ...]`.

Code blocks, comments and tables are left out of words and sentences. The last lines list the pages that break a rule.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import NamedTuple

from places import ROOT

MAX_MEAN = 20.0
"""Largest mean length of a page's sentences [words]; `measure` counts a list item as a sentence."""

MAX_WORDS = 2500
"""Most words of a page [-]."""

MAX_COLUMNS = 120
"""Longest source line outside tables and code, not counting the targets of links [characters]."""

HASHES_ALLOWED = ("docs/history.md", "docs/results/")
"""Pages that may name a revision."""

CODE = re.compile(r"^[ \t]*(?P<fence>`{3,}|~{3,}).*?^[ \t]*(?P=fence)[ \t]*$", re.MULTILINE | re.DOTALL)
COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
TARGET = re.compile(r"\]\([^()\s]+(?: \"[^\"]*\")?\)")
LINK = re.compile(r"!?\[((?:[^][]|\[[^][]*\])*)\]\([^()\s]+(?: \"[^\"]*\")?\)")
HASH = re.compile(r"\b(?=[0-9a-f]*[a-f])(?=[0-9a-f]*\d)[0-9a-f]{7,40}\b")
SENTENCE_END = re.compile(r"(?<=[.?!:])[\"')\]*]*\s+(?=[^a-z\s]|[\w./-]+\.(?:md|csv|db)\b)")
PARAGRAPH = re.compile(r"\n\s*\n|\n(?=\s*(?:[-*+]|\d+\.)\s)|\n(?=#)|(?<=\n)(?=\|)")
STARTS = re.compile(r"^\s*(?:[-*+]|\d+\.|#+|>)\s+")


class Prose(NamedTuple):
    """What a page holds."""

    page: Path
    words: int
    mean: float
    """Mean length of the sentences [words]."""
    longest: str
    """Longest sentence."""
    long_lines: tuple[int, ...]
    """Numbers of the lines outside tables and code that are too long."""
    hashes: tuple[str, ...]
    """Revisions that the page names."""

    def faults(self) -> list[str]:
        """Return the rules that the page breaks."""
        found = []
        if self.words > MAX_WORDS:
            found.append(f"{self.words} words, at most {MAX_WORDS}")
        if self.mean > MAX_MEAN:
            found.append(f"{self.mean:.1f} words a sentence, at most {MAX_MEAN:.0f}")
        if self.long_lines:
            found.append(f"lines above {MAX_COLUMNS} characters: {', '.join(map(str, self.long_lines[:5]))}")
        if self.hashes:
            found.append(f"revisions: {', '.join(self.hashes[:5])}")
        return found


def pages() -> list[Path]:
    """Return all Markdown pages of the project except the changelog."""
    folders = [path for name in ("docs", "robots", "viewer") for path in (ROOT / name).glob("**/*.md")]
    found = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *folders]
    return sorted(page for page in found if "node_modules" not in page.parts)


def measure(page: Path) -> Prose:
    """Return what a page holds."""
    text = page.read_text(encoding="utf-8")
    name = page.relative_to(ROOT).as_posix() if page.is_relative_to(ROOT) else page.name
    blank = CODE.sub(lambda match: "\n" * match[0].count("\n"), text)
    long_lines = [
        number
        for number, line in enumerate(blank.splitlines(), 1)
        if len(TARGET.sub("]", line)) > MAX_COLUMNS and not line.lstrip().startswith("|")
    ]
    found = sentences(blank)
    counts = [len(sentence.split()) for sentence in found]
    hashes = () if name.startswith(HASHES_ALLOWED) else tuple(HASH.findall(COMMENT.sub("", blank)))
    longest = max(found, key=lambda sentence: len(sentence.split()), default="")
    return Prose(page, sum(counts), sum(counts) / max(len(counts), 1), longest, tuple(long_lines), hashes)


def sentences(text: str) -> list[str]:
    """Return the sentences of Markdown without code blocks; a heading counts as none, its words are left out."""
    plain = LINK.sub(r"\1", COMMENT.sub("", text))
    paragraphs = [STARTS.sub("", part).strip() for part in PARAGRAPH.split(plain) if not part.lstrip().startswith("#")]
    prose = [" ".join(part.split()) for part in paragraphs if part and not part.startswith("|")]
    return [sentence for part in prose for sentence in SENTENCE_END.split(part) if re.search(r"\w", sentence)]


def main() -> int:
    """Print a line for each page; return 1 if a page breaks a rule."""
    chosen = [Path(name).resolve() for name in sys.argv[1:]] or pages()
    measured = [measure(page) for page in chosen]
    print(f"{'words':>6} {'mean':>5} {'longest':>7} {'lines':>5}  page")
    for prose in measured:
        numbers = f"{prose.words:6} {prose.mean:5.1f} {len(prose.longest.split()):7} {len(prose.long_lines):5}"
        print(f"{numbers}  {prose.page.relative_to(ROOT)}")
        if sys.argv[1:]:
            print(f"       longest: {prose.longest}")
    print(f"{sum(prose.words for prose in measured):6} words")
    broken = [(prose.page.relative_to(ROOT), fault) for prose in measured for fault in prose.faults()]
    for page, fault in broken:
        print(f"{page}: {fault}")
    return int(bool(broken))


if __name__ == "__main__":
    sys.exit(main())
