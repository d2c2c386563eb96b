"""Links of the pages, for a site that holds the documentation and the files that it names.

Pages are written for readers of the repository, so a link may lead to a module, a scenario or a hand's README. The site
shows each such file as a page below `source/`.
"""

from __future__ import annotations

import os
import posixpath
import re
from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
"""Folder of the repository."""

DOCS = ROOT / "docs"
"""Folder of the pages."""

LINK = re.compile(r'(?<=\]\()(?P<target>[^()\s]+)(?P<title> "[^"]*")?(?=\))')
"""Target and title of a Markdown link."""

LANGUAGES = {".py": "python", ".toml": "toml", ".xml": "xml", ".urdf": "xml", ".js": "javascript", ".html": "html"}
"""Language of a shown file by its suffix; others are shown as text."""

ASSETS = (".png", ".jpg", ".gif", ".svg", ".html", ".json", ".csv", ".xz", ".ipynb")
"""Suffixes of files that a page links to as they are."""


def is_elsewhere(target: str) -> bool:
    """Return whether a link leaves the repository or stays on its page."""
    return target.startswith(("http://", "https://", "mailto:", "#"))


def site_path(file: Path) -> str:
    """Return where the site has a file of the repository, as the path of its source."""
    if file.is_relative_to(DOCS) and (file.suffix == ".md" or file.suffix in ASSETS):
        # `README.md` becomes the `index.html` of its folder.
        shown = file.with_name("page.html") if file.name == "index.html" else file
        return shown.relative_to(DOCS).as_posix()
    relative = file.relative_to(ROOT).as_posix()
    return f"source/{relative}" if file.suffix == ".md" else f"source/{relative}.md"


def linked_files(page: Path) -> Iterable[Path]:
    """Return the files of the repository to which a page leads."""
    for match in LINK.finditer(page.read_text(encoding="utf-8")):
        target = match["target"].partition("#")[0]
        if target and not is_elsewhere(target):
            file = (page.parent / target).resolve()
            if file.is_file():
                yield file


def for_site(text: str, page: Path) -> str:
    """Return the text of a page with links that lead to the site's pages.

    `page` is the file from which the text comes.
    """
    here = posixpath.dirname(site_path(page))

    def replaced(match: re.Match[str]) -> str:
        target, hash_mark, anchor = match["target"].partition("#")
        if is_elsewhere(match["target"]) or not target:
            return match[0]
        file = (page.parent / target).resolve()
        if not file.is_file():
            raise FileNotFoundError(f"{page.relative_to(ROOT)}: the link {match['target']!r} leads to no file")
        # The numbered lines of a shown file have anchors of their own.
        line = re.fullmatch(r"L(\d+)", anchor)
        anchor = f"__codelineno-0-{line[1]}" if line else anchor
        return f"{posixpath.relpath(site_path(file), here or '.')}{hash_mark}{anchor}{match['title'] or ''}"

    return LINK.sub(replaced, text)


def shown_file(file: Path) -> str:
    """Return the page that shows a file, with numbered lines."""
    text = file.read_text(encoding="utf-8").rstrip("\n")
    fence = "`" * (1 + max((len(run) for run in re.findall(r"`{3,}", text)), default=2))
    language = LANGUAGES.get(file.suffix, "text")
    name = os.fspath(file.relative_to(ROOT))
    head = f"---\nsearch:\n  exclude: true\n---\n# `{name}`\n\n"
    return f'{head}{fence}{language} linenums="1"\n{text}\n{fence}\n'
