"""Parts of the figures: colours, panels, rates with intervals, violins and legends."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import asdict, dataclass

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pilegrasp_ctrl.scenarios.paper.evidence import Sample
from pilegrasp_ctrl.study.charts import figure_style, page_colours

HEIGHT = 3.0
"""Height of every figure [in]; chosen."""


@dataclass(frozen=True, slots=True)
class Palette:
    """Colours by their meaning.

    Attributes:
        ink: Colour of titles and legends.
        soft: Colour of axis labels.
        rule: Colour of axes and grid.
        first: Colour of the first series: blue, as in the paper.
        second: Colour of the second series: yellow.
        third: Colour of the third series: green.
        fourth: Colour of the fourth series: red.
        paper: Colour of numbers that the paper states.
    """

    ink: str
    soft: str
    rule: str
    first: str
    second: str
    third: str
    fourth: str
    paper: str

    def style(self) -> AbstractContextManager[None]:
        """Return the context in which figures are drawn and saved."""
        return figure_style(self.ink, self.soft, self.rule)

    def as_dict(self) -> dict[str, str]:
        """Return the colours by name."""
        return asdict(self)


LIGHT = Palette("#1d2126", "#646b74", "#d9dce0", "#2166c4", "#c98a00", "#2a8a4a", "#b3261e", "#7b3fb5")
"""Colours of the figures in files."""
PAGE = Palette(**page_colours("ink", "soft", "rule", "first", "second", "third", "fourth", "paper"))
"""Placeholder colours of the figures in the page, whose style sheet defines a light and a dark form."""


def panels(count: int = 1, width: float = 6.2, titles: Sequence[str] = ()) -> tuple[Figure, list[Axes]]:
    """Return a figure with axes side by side."""
    figure = Figure(figsize=(width, HEIGHT))
    axes = list(figure.subplots(1, count, squeeze=False)[0])
    for place, title in zip(axes, titles, strict=False):
        place.set_title(title, loc="left")
    return figure, axes


def set_rate_axis(axes: Axes, label: str = "success [%]") -> None:
    """Set the y axis to a rate from 0 to 100 %."""
    axes.set_ylim(-4.0, 104.0)
    axes.set_yticks(range(0, 101, 20))
    axes.set_ylabel(label)
    axes.grid(axis="y")


def set_categories(axes: Axes, names: Sequence[str]) -> None:
    """Write category names below x = 0, 1, ..."""
    axes.set_xticks(range(len(names)), names)
    axes.set_xlim(-0.6, len(names) - 0.4)


def draw_rates(
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
    """Draw rates with their 95 % intervals, dashed and hollow if the paper simulated them."""
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


def draw_stated(
    axes: Axes, x: Sequence[float], values: Sequence[float], palette: Palette, label: str = "paper, stated"
) -> None:
    """Mark rates that the paper states [%]."""
    axes.plot(x, values, linestyle="none", marker="D", markersize=5, mfc="none", mec=palette.paper, label=label)


def draw_violins(
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


def put_legend_above(figure: Figure, axes: Axes, columns: int = 4) -> None:
    """Put the legend above the panels."""
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, loc="outside upper left", ncols=columns, handlelength=2.2)
