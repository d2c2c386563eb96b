"""The figures of the page of a search: the objective over each parameter, and over pairs of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations, pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..study.charts import figure_style, page_colours, svg_element
from ..types import Array
from .evidence import mean_interval
from .race import ERROR, Candidate
from .run import SearchResult
from .space import Choice, Parameter

COLOURS = page_colours("ink", "soft", "rule", "start", "best", "front", "bad")
"""Placeholder colour of each name; the style sheet of `study/result.html` defines the colours themselves."""
INK, SOFT, RULE, START, BEST, FRONT, BAD = COLOURS.values()
"""The same colours one by one."""
SIZE = (3.4, 2.5)
"""Width and height of a panel [in] (chosen)."""
MAX_PAIRS = 6
"""Largest number of pairs of parameters that are drawn (chosen)."""
BINS = 5
"""Number of parts of a range over which the attempts of all candidates are counted together (chosen)."""


@figure_style(INK, SOFT, RULE)
def over_parameter(result: SearchResult, parameter: Parameter) -> str:
    """Return the value of every candidate over one parameter, with intervals, and that of all attempts near it."""
    figure = Figure(figsize=SIZE)
    axes = figure.subplots()
    most = max(candidate.n for candidate in result.race.candidates)
    for candidate in result.race.candidates:
        if candidate.samples is None:
            continue
        place = _place(parameter, candidate.values[parameter.key])
        if place is None:
            continue
        colour, size = _style(result, candidate)
        value = result.race.value(candidate)
        if not result.search.objective.timed:
            low, high = mean_interval(_worst(candidate), ERROR)
            axes.plot([place, place], [low, high], color=colour, linewidth=0.8, alpha=_weight(candidate, most))
        strength = 1.0 if size > 20 else _weight(candidate, most)
        axes.scatter([place], [value], s=size, color=colour, alpha=strength, zorder=3 if size > 20 else 2)
    for low, high, value in _together(result, parameter):
        axes.plot([low, high], [value, value], color=SOFT, linewidth=2.0, alpha=0.6)
    _scale(axes, parameter, "x")
    axes.set(xlabel=parameter.key, ylabel=result.search.objective.words.partition(" that")[0])
    axes.grid(axis="y")
    return svg_element(figure, f"objective over {parameter.key}", COLOURS)


@figure_style(INK, SOFT, RULE)
def over_pair(result: SearchResult, one: Parameter, other: Parameter) -> str:
    """Return the value of every candidate as the darkness of a mark over two parameters."""
    figure = Figure(figsize=SIZE)
    axes = figure.subplots()
    known = [each for each in result.race.candidates if each.samples is not None]
    best = max((result.race.value(each) for each in known), default=0.0) or 1.0
    for candidate in known:
        x, y = (_place(parameter, candidate.values[parameter.key]) for parameter in (one, other))
        if x is not None and y is not None:
            share = result.race.value(candidate) / best
            colour, size = _style(result, candidate)
            axes.scatter([x], [y], s=max(size, 30), color=colour, alpha=0.1 + 0.9 * share**2)
    _scale(axes, one, "x")
    _scale(axes, other, "y")
    axes.set(xlabel=one.key, ylabel=other.key)
    return svg_element(figure, f"objective over {one.key} and {other.key}", COLOURS)


def pairs(parameters: Sequence[Parameter]) -> list[tuple[Parameter, Parameter]]:
    """Return the pairs of parameters that are drawn."""
    return list(combinations(parameters, 2))[:MAX_PAIRS]


def _weight(candidate: Candidate, most: int) -> float:
    """Return the opacity of a candidate: the fewer seeds it has, the paler it is."""
    return 0.15 + 0.65 * math.sqrt(candidate.n / most)


def _style(result: SearchResult, candidate: Candidate) -> tuple[str, int]:
    """Return colour and size of a candidate's mark."""
    if candidate is result.winner:
        return BEST, 60
    if candidate.number == 0:
        return START, 50
    return (BAD, 10) if candidate.eliminated_by is not None else (FRONT, 14)


def _worst(candidate: Candidate) -> Array:
    """Return the scores (n,) of a candidate in its worst world."""
    if candidate.samples is None:
        return np.zeros(0)
    score = candidate.samples.score
    return score[:, int(score.mean(axis=0).argmin())]


def _together(result: SearchResult, parameter: Parameter) -> list[tuple[float, float, float]]:
    """Return parts of a parameter, from and to, with the mean of their candidates' values, by number of attempts."""
    count = len(parameter.values) if isinstance(parameter, Choice) else BINS
    edges = np.linspace(0.0, 1.0, count + 1)
    found = []
    for low, high in pairwise(edges.tolist()):
        rows = []
        for each in result.race.candidates:
            share = parameter.share(each.values[parameter.key])
            if each.samples is not None and share is not None and low <= share < high + (high == 1.0):
                rows.append((result.race.value(each), each.n))
        if rows:
            values, weights = zip(*rows, strict=True)
            mean = float(np.average(values, weights=weights))
            found.append((_at(parameter, low, count), _at(parameter, high, count), mean))
    return found


def _at(parameter: Parameter, share: float, count: int) -> float:
    """Return the place on the axis of a share."""
    if isinstance(parameter, Choice):
        return share * count - 0.5
    return float(parameter.low + share * (parameter.high - parameter.low))


def _place(parameter: Parameter, value: Any) -> float | None:
    """Return the place of a value on an axis; None for one that has none."""
    if isinstance(parameter, Choice):
        return float(parameter.values.index(value)) if value in parameter.values else None
    return float(value) if isinstance(value, int | float) else None


def _scale(axes: Axes, parameter: Parameter, side: str) -> None:
    if isinstance(parameter, Choice):
        names = [str(value)[-16:] for value in parameter.values]
        axes.set(**{f"{side}ticks": range(len(names)), f"{side}ticklabels": names})  # type: ignore[arg-type]
