"""Check the built site: `python docs/site/check.py build/site`.

Every link must lead to a file and an anchor that exist, nothing may be loaded from another machine, and no list or
table may have been taken for a paragraph.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

LOADED = {"script": "src", "img": "src", "link": "href", "iframe": "src", "source": "src", "video": "src"}
"""Attribute by which an element loads something."""

UNREAD = re.compile(r"^\s*(?:[-*] |\d+\. |\|.*\|$|```)", re.MULTILINE)
"""A line of a list, a table or a fence that has stayed text."""


class Page(HTMLParser):
    """What a page links to, loads, and can be linked to."""

    def __init__(self, file: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.loads: list[str] = []
        self.anchors: set[str] = set()
        self.paragraphs: list[str] = []
        self._open: list[str] = []
        self.feed(file.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note anchors, links and what is loaded."""
        values = dict(attrs)
        self.anchors |= {value for name in ("id", "name") if (value := values.get(name))}
        if tag == "a" and (target := values.get("href")):
            self.links.append(target)
        if (
            tag in LOADED
            and (target := values.get(LOADED[tag]))
            and values.get("rel") not in ("canonical", "next", "prev")
        ):
            self.loads.append(target)
        if tag == "p":
            self.paragraphs.append("")
        self._open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        """Close an element, and those in it that have no end."""
        if tag in self._open:
            while self._open.pop() != tag:
                pass

    def handle_data(self, data: str) -> None:
        """Keep the text of paragraphs, without that of code."""
        if "p" in self._open and "code" not in self._open:
            self.paragraphs[-1] += data


def problems(site: Path) -> list[str]:
    """Return a sentence for each broken link, foreign load and unread list."""
    pages = cache(Page)
    found = []
    for file in sorted(site.rglob("*.html")):
        # The page of a recording or of a study has tests of its own.
        if 'class="md-container"' not in file.read_text(encoding="utf-8"):
            continue
        page, name = pages(file), file.relative_to(site)
        found += [f"{name} loads {target}" for target in page.loads if urlsplit(target).netloc]
        unread = [text.strip() for text in page.paragraphs if UNREAD.search(text)]
        found += [f"{name} has a list or a table that is text: {text[:60]!r}" for text in unread]
        # The page of an unknown address is served from everywhere, so its links are absolute.
        for target in (*page.links, *page.loads) if file.name != "404.html" else ():
            fault = _fault(file, target, pages)
            if fault:
                found.append(f"{name} links to {target}: {fault}")
    return found


def _fault(file: Path, target: str, pages: Callable[[Path], Page]) -> str | None:
    parts = urlsplit(target)
    if parts.scheme or parts.netloc:
        return None
    place = (file.parent / unquote(parts.path)).resolve() if parts.path else file
    place = place / "index.html" if place.is_dir() else place
    if not place.is_file():
        return "there is no such file"
    anchor = unquote(parts.fragment)
    known = not anchor or place.suffix != ".html" or anchor in pages(place).anchors
    return None if known else "there is no such anchor"


if __name__ == "__main__":
    faults = problems(Path(sys.argv[1]))
    print("\n".join(faults) or "Every link of the site leads somewhere, and nothing is loaded from elsewhere.")
    sys.exit(bool(faults))
