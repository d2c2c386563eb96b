"""The style of the figures that pages show, and each drawing as an element of a page.

A page has a light and a dark form. Its figures are drawn once, in placeholder colours that nothing else uses.
`svg_element` replaces each of them by a CSS variable, and the page's style sheet defines both values of that variable.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure


def page_colours(*names: str) -> dict[str, str]:
    """Return a placeholder colour for each name; `svg_element` writes it as `var(--name)`."""
    return {name: f"#0102{place:02x}" for place, name in enumerate(names, start=3)}


@contextmanager
def figure_style(ink: str, soft: str, rule: str) -> Iterator[None]:
    """Draw in the style of the pages, whatever the user's own settings of matplotlib are.

    Args:
        ink: Colour of titles and legends.
        soft: Colour of axis labels and ticks.
        rule: Colour of axes and grid.
    """
    style: Any = {
        "svg.fonttype": "none",
        "svg.hashsalt": "pilegrasp",
        "font.family": "sans-serif",
        "font.size": 9.0,
        "text.color": ink,
        "axes.edgecolor": rule,
        "axes.labelcolor": soft,
        "axes.facecolor": "none",
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.titlesize": 9.0,
        "axes.titlecolor": ink,
        "xtick.color": soft,
        "ytick.color": soft,
        "grid.color": rule,
        "grid.linewidth": 0.6,
        "legend.frameon": False,
        "legend.fontsize": 8.0,
        "legend.labelcolor": ink,
        "lines.linewidth": 1.6,
        "figure.constrained_layout.use": True,
    }
    with mpl.rc_context({**mpl.rcParamsDefault, **style}):
        yield


def svg_element(figure: Figure, description: str, colours: Mapping[str, str], prefix: str = "") -> str:
    """Return a drawing as an element of an HTML page, without declarations, addresses and a fixed size.

    Args:
        figure: Drawing, still in the style in which it was made.
        description: Label for screen readers.
        colours: Placeholder colours by name, of `page_colours`.
        prefix: Prefix of the ids in the drawing. Ids must differ between drawings that share a page.
    """
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", facecolor="none", metadata={"Date": None, "Creator": None})
    text = buffer.getvalue()
    text = re.sub(r"<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.DOTALL)
    text = re.sub(r'\sxmlns(:xlink)?="[^"]*"', "", text).replace("xlink:href", "href")
    if prefix:
        text = re.sub(r'(id="|href="#|url\(#)', rf"\g<1>{prefix}", text)
    text = re.sub(
        r'<svg [^>]*?(viewBox="[^"]*")[^>]*>', rf'<svg \1 role="img" aria-label="{description}">', text, count=1
    )
    for name, colour in colours.items():
        text = text.replace(colour, f"var(--{name})")
    return text
