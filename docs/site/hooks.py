"""Hooks of MkDocs: the navigation, the generated pages, and the form of pages that are written for the repository."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, InclusionLevel

from links import DOCS, ROOT, for_site, linked_files, shown_file, site_path

sys.path.append(str(ROOT / "tests" / "helpers"))

from reference import generated_pages

INDEX = DOCS / "README.md"
"""Page whose sections and tables are the navigation."""

ASSETS = ("iframe-worker.js", "site.css")
"""Files of this folder that the site loads."""

BOOSTED = {"questions.md": 4, "reference/keys.md": 2, "source/CHANGELOG.md": 0.3, "history.md": 0.5}
"""Weight of pages in the search; that of others is 1."""

_ROW = re.compile(r"^\| \[[^\]]*\]\(([^)#]+)\)", re.MULTILINE)
_FENCE = re.compile(r"^(?P<fence>`{3,})(?P<language>[\w-]+)[ \t]+(?P<name>[^\s=]+)[ \t]*$", re.MULTILINE)
_ITEM = re.compile(r"[-*] |\d+\. ")

_sources: dict[str, Path] = {}


def navigation() -> list[dict[str, Any]]:
    """Return the navigation: a section of the index is a section of the site, a row of its table is a page."""
    text = INDEX.read_text(encoding="utf-8")
    parts: list[dict[str, Any]] = [{"Home": "README.md"}]
    for section in re.split(r"^## ", text, flags=re.MULTILINE)[1:]:
        title = section.partition("\n")[0].strip()
        targets = [(DOCS / target).resolve() for target in _ROW.findall(section)]
        pages: list[Any] = [site_path(target) for target in targets]
        pages += [name for name in generated_pages() if title == "Reference"]
        if pages:
            parts.append({title: pages})
    return parts


def on_config(config: Any) -> Any:
    """Take the navigation from the index."""
    config.nav = navigation()
    config.watch += [str(DOCS.parent / "pilegrasp_ctrl"), str(Path(__file__).parent)]
    return config


def on_files(files: Any, config: Any) -> Any:
    """Add what is generated, what stands outside docs/ and is linked to, and the scripts of the site."""
    _sources.clear()
    for name in ASSETS:
        files.append(File.generated(config, f"assets/{name}", abs_src_path=str(Path(__file__).with_name(name))))
    for uri, text in generated_pages().items():
        files.append(File.generated(config, uri, content=text))
    waiting = [Path(file.abs_src_path) for file in files.documentation_pages() if file.generated_by is None]
    seen = set(waiting)
    while waiting:
        for file in linked_files(waiting.pop()):
            if file in seen:
                continue
            seen.add(file)
            uri = site_path(file)
            if uri.startswith("source/"):
                text = file.read_text(encoding="utf-8") if file.suffix == ".md" else shown_file(file)
                files.append(File.generated(config, uri, content=text))
                _sources[uri] = file
            if file.suffix == ".md":
                waiting.append(file)
            elif files.get_file_from_path(uri) is None:
                files.append(File.generated(config, uri, abs_src_path=str(file)))
    listed = [uri for part in config.nav for uri in pages_of(part)]
    for file in files.documentation_pages():
        if file.src_uri.startswith("source/") and file.src_uri not in listed:
            file.inclusion = InclusionLevel.NOT_IN_NAV
    return files


def pages_of(part: dict[str, Any]) -> list[str]:
    """Return the pages of a section of the navigation."""
    ((_, pages),) = part.items()
    return [pages] if isinstance(pages, str) else pages


def on_page_markdown(markdown: str, page: Any, config: Any, files: Any) -> str:
    """Give a page the links of the site, and a block of code the name of its file as a title."""
    if page.file.src_uri in BOOSTED:
        page.meta.setdefault("search", {"boost": BOOSTED[page.file.src_uri]})
    file = _sources.get(page.file.src_uri)
    if file is None and page.file.generated_by is None:
        file = Path(page.file.abs_src_path)
    if file is not None and file.suffix != ".md":
        return markdown
    if file is not None:
        markdown = for_site(markdown, file)
    return for_python_markdown(_FENCE.sub(r'\g<fence>\g<language> title="\g<name>"', markdown))


def for_python_markdown(markdown: str) -> str:
    """Return a text with lists as Python-Markdown wants them: behind a blank line, with four columns of indentation."""
    lines: list[str] = []
    fenced, width = False, 0
    for line in markdown.split("\n"):
        item, before = _ITEM.match(line), lines[-1] if lines else ""
        if item and not fenced:
            if before.strip() and (not width or before.strip() == "```"):
                lines.append("")
            width = len(item[0])
        elif line.strip() and line[0] != " " and not fenced and not before.strip():
            width = 0
        if line.lstrip().startswith("```"):
            if width and not fenced and before.strip():
                lines.append("")
            fenced = not fenced
        lines.append(" " * (4 - width) + line if width and line.startswith(" " * width) else line)
    return "\n".join(lines)
