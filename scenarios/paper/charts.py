"""Pieces of the figures: rates with intervals, violins, and drawings as files or as parts of a page."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.scenarios.paper.experiment import Experiment
from pilegrasp_ctrl.scenarios.paper.palette import LIGHT, NAMED, Palette
from pilegrasp_ctrl.scenarios.paper.sample import Sample

HEIGHT = 3.0
"""Of a figure [in]."""


def panels(count: int = 1, width: float = 6.2, titles: Sequence[str] = ()) -> tuple[Figure, list[Axes]]:
    """Return a figure with axes side by side."""
    figure = Figure(figsize=(width, HEIGHT))
    axes = list(figure.subplots(1, count, squeeze=False)[0])
    for place, title in zip(axes, titles, strict=False):
        place.set_title(title, loc="left")
    return figure, axes


def rate_axis(axes: Axes, label: str = "success [%]") -> None:
    """Make y a rate from 0 to 100 %."""
    axes.set_ylim(-4.0, 104.0)
    axes.set_yticks(range(0, 101, 20))
    axes.set_ylabel(label)
    axes.grid(axis="y")


def categories(axes: Axes, names: Sequence[str]) -> None:
    """Write names below x = 0, 1, ..."""
    axes.set_xticks(range(len(names)), names)
    axes.set_xlim(-0.6, len(names) - 0.4)


def rates(
    axes: Axes,
    x: Sequence[float],
    samples: Sequence[Sample],
    colour: str,
    label: str,
    *,
    simulated: bool = False,
    joined: bool = True,
    marker: str = "o",
) -> None:
    """Draw rates with their 95 % intervals; dashed and hollow for what stands for the paper's simulation."""
    chosen = [(place, sample) for place, sample in zip(x, samples, strict=True) if sample.n]
    if not chosen:
        return
    places = [place for place, _ in chosen]
    values = [100.0 * sample.rate for _, sample in chosen]
    for place, sample in chosen:
        low, high = sample.interval
        thin = ":" if simulated else "-"
        axes.plot([place, place], [100.0 * low, 100.0 * high], thin, color=colour, linewidth=1.0, alpha=0.8)
    fill = "none" if simulated else colour
    line = ("--" if simulated else "-") if joined else "none"
    axes.plot(places, values, linestyle=line, color=colour, marker=marker, markersize=5, mfc=fill, label=label)


def stated(
    axes: Axes, x: Sequence[float], values: Sequence[float], palette: Palette, label: str = "paper, stated"
) -> None:
    """Mark what the paper states [%]."""
    axes.plot(x, values, linestyle="none", marker="D", markersize=5, mfc="none", mec=palette.paper, label=label)


def violins(
    axes: Axes, x: Sequence[float], data: Sequence[Sequence[float]], colours: Sequence[str], dashed: bool
) -> None:
    """Draw kernel densities of rates, limited to the data, with means [%]."""
    for place, values, colour in zip(x, data, colours, strict=True):
        if not values:
            continue
        shape = axes.violinplot([100.0 * value for value in values], [place], widths=0.36, showextrema=False)
        for body in shape["bodies"]:  # type: ignore[attr-defined]
            body.set(facecolor=colour, edgecolor=colour, alpha=0.35, linestyle="--" if dashed else "-")
        mean = 100.0 * sum(values) / len(values)
        axes.plot([place - 0.1, place + 0.1], [mean, mean], color=colour, linestyle="--" if dashed else "-")


def legend_above(figure: Figure, axes: Axes, columns: int = 4) -> None:
    """Put the legend over the panels."""
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, loc="outside upper left", ncols=columns, handlelength=2.2)


def _drawn(experiment: Experiment, evidence: Evidence, palette: Palette, suffix: str) -> bytes:
    style: Any = {**mpl.rcParamsDefault, **palette.style()}
    with mpl.rc_context(style):
        buffer = io.BytesIO()
        page = palette is NAMED
        metadata = {"Date": None, "Creator": None} if suffix == "svg" else {"Software": None}
        figure = experiment.draw(evidence, palette)
        colour = "none" if page else "white"
        figure.savefig(buffer, format=suffix, dpi=160, facecolor=colour, metadata=metadata)
    return buffer.getvalue()


def save(experiment: Experiment, evidence: Evidence, folder: Path) -> list[str]:
    """Write the figure as SVG and PNG; return the files' names."""
    names = [f"{experiment.name}.{suffix}" for suffix in ("svg", "png")]
    for name in names:
        (folder / name).write_bytes(_drawn(experiment, evidence, LIGHT, name.rpartition(".")[2]))
    return names


def inline(experiment: Experiment, evidence: Evidence) -> str:
    """Return the figure as an element of a page: no declarations, no addresses, the page's own colours."""
    text = _drawn(experiment, evidence, NAMED, "svg").decode()
    text = re.sub(r"<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.DOTALL)
    text = re.sub(r'\sxmlns(:xlink)?="[^"]*"', "", text).replace("xlink:href", "href")
    # Several drawings share a page, and so must not share the names of their parts.
    text = re.sub(r'(id="|href="#|url\(#)', rf"\g<1>{experiment.name}-", text)
    text = re.sub(
        r'<svg [^>]*?(viewBox="[^"]*")[^>]*>', rf'<svg \1 role="img" aria-label="{experiment.title}">', text, count=1
    )
    for name, colour in NAMED.items():
        text = text.replace(colour, f"var(--{name})")
    return text
