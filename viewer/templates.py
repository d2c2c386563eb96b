"""Templates of the pages: every value that is put into one is escaped, unless it is `Markup` already."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

_VIEWER = Path(__file__).parent


@cache
def _environment() -> Environment:
    return Environment(
        loader=FileSystemLoader([_VIEWER, _VIEWER.parent]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )


def render(template: str, **values: Any) -> Markup:
    """Return a template of this folder or of the package, such as `page/page.html`, with its values escaped."""
    return Markup(_environment().get_template(template).render(values))


def trusted(path: str) -> Markup:
    """Return the text of a file of this folder, such as a style sheet, to be put into a page as it is."""
    return Markup((_VIEWER / path).read_text(encoding="utf-8"))
