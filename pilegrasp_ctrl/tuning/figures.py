"""The figures of the page of a search: small panels, each an SVG in the colours of the page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..study.charts import figure_style, page_colours, svg_element
from .analysis import AXIS_NAMES, Contender, SearchAnalysis, SweepPoint
from .objectives import MEASURE_NAMES, UNITS, Measured, objective_names
from .stability_margin import MAX_RINGING
from .store import TrialRecord

COLOURS = page_colours("ink", "soft", "rule", "start", "best", "front", "bad")
"""Placeholder colour of each name; the style sheet of `study/result.html` defines the colours themselves."""
INK, SOFT, RULE, START, BEST, FRONT, BAD = COLOURS.values()
"""The same colours one by one: text, axis labels, grid, start, best, Pareto front, and ringing or failed trials."""
WIDE = (4.4, 3.1)
"""Width and height of a panel that shows all trials [in] (chosen)."""
SMALL = (3.0, 2.1)
"""Width and height of a panel for one axis or one gain [in] (chosen)."""
LABELS = {name: f"{MEASURE_NAMES[name]} [{UNITS[name]}]" for name in ("tracking", "activity", "overshoot")}
"""Axis label of each objective."""

_KINDS = ((False, "x", BAD, "rings too early"), (True, "o", SOFT, "keeps the margin"))
"""Marker, colour and label of trials that are not feasible, and of those that are."""


@figure_style(INK, SOFT, RULE)
def trade_off(analysis: SearchAnalysis, x: str) -> str:
    """Return a plot of tracking over another objective, with all trials, the front, the start and the best."""
    figure, axes = _panel(WIDE)
    rows = [record for record in analysis.records if record.report.measured is not None]
    for kept, marker, colour, label in _KINDS:
        chosen = [record for record in rows if record.report.feasible is kept]
        if chosen:
            style: dict[str, Any] = {"facecolor": "none"} if kept else {}
            axes.scatter(*_plane(chosen, x), s=16, marker=marker, color=colour, linewidth=0.9, label=label, **style)
    front = analysis.front
    if len(front) > 1 and len(objective_names(analysis.search.scenario)) == 2:
        axes.plot(*_plane(front, x), color=FRONT, linewidth=1.2, zorder=1)
    axes.scatter(*_plane(front, x), s=16, color=FRONT, label="Pareto front")
    for contender, marker, colour, label in (
        (analysis.start, "^", START, "start"),
        (analysis.best, "*", BEST, "best"),
    ):
        if contender.record.report.measured is not None:
            size = 150 if marker == "*" else 70
            axes.scatter(*_plane([contender.record], x), s=size, marker=marker, color=colour, label=label, zorder=3)
    axes.set(xscale="linear" if x == "overshoot" else "log", yscale="log", xlabel=LABELS[x], ylabel=LABELS["tracking"])
    _plain_ticks(axes)
    _legend_above(figure, axes, 3)
    return svg_element(figure, f"tracking error against {LABELS[x]}", COLOURS)


@figure_style(INK, SOFT, RULE)
def history(analysis: SearchAnalysis) -> str:
    """Return the tracking error of every trial, and the smallest with margin so far."""
    figure, axes = _panel(WIDE)
    rows = [record for record in analysis.records if record.report.measured is not None]
    errors = [_of(record, "tracking") if record.report.feasible else np.inf for record in rows]
    numbers = [record.number for record in rows]
    for kept, marker, colour, _ in _KINDS:
        chosen = [record for record in rows if record.report.feasible is kept]
        style: dict[str, Any] = {"facecolor": "none"} if kept else {}
        if chosen:
            tracking = [_of(record, "tracking") for record in chosen]
            chosen_numbers = [record.number for record in chosen]
            axes.scatter(chosen_numbers, tracking, s=14, marker=marker, color=colour, linewidth=0.9, **style)
    axes.step(numbers, np.minimum.accumulate(errors), where="post", color=BEST, label="smallest with margin so far")
    failed = [record.number for record in analysis.records if record.report.measured is None]
    for place, number in enumerate(failed):
        axes.axvline(number, color=BAD, linewidth=0.6, label="not completed" if place == 0 else None)
    axes.set(yscale="log", xlabel="trial", ylabel=LABELS["tracking"])
    _plain_ticks(axes)
    _legend_above(figure, axes, 2)
    return svg_element(figure, "tracking error over the trials", COLOURS)


@figure_style(INK, SOFT, RULE)
def step_panel(analysis: SearchAnalysis, axis: int) -> str:
    """Return the responses of start and best to a step along one axis, as a share of it."""
    figure, axes = _panel(SMALL)
    axes.axhline(1.0, color=SOFT, linewidth=0.6)
    for contender, colour, style, label in (
        (analysis.start, START, "--", "start"),
        (analysis.best, BEST, "-", "best"),
    ):
        response = contender.responses[axis]
        if response is not None:
            covered = 1.0 - response.error[:, axis] / response.step[axis]
            axes.plot(1e3 * response.time, covered, style, color=colour, label=label)
    axes.set(title=AXIS_NAMES[axis], xlabel="time [ms]", xlim=(0.0, 1e3 * _moving(analysis)), ylim=(-0.1, 1.6))
    axes.grid(axis="y")
    axes.legend(loc="lower right")
    return svg_element(figure, f"step response, {AXIS_NAMES[axis]}", COLOURS)


@figure_style(INK, SOFT, RULE)
def margin_panel(analysis: SearchAnalysis) -> str:
    """Return the ringing over the factor on the stiffness, as simulated and a control period later."""
    figure, axes = _panel(WIDE)
    for contender, colour, label in ((analysis.start, START, "start"), (analysis.best, BEST, "best")):
        for late, margin in contender.margins.items():
            factors, ringing = np.array(margin.probes).T
            name = label if late == 0 else f"{label}, {late} period{'s' if late > 1 else ''} later"
            style = ("-", "--", ":")[min(late, 2)]
            axes.plot(factors, np.clip(ringing, 1e-2, MAX_RINGING), style, marker=".", color=colour, label=name)
    axes.axhline(1.0, color=BAD, linewidth=1.0)
    axes.axvline(1.0, color=RULE, linewidth=0.8)
    axes.set(xscale="log", yscale="log", xlabel="factor on the stiffness", ylabel="ringing (1 and above rings)")
    _plain_ticks(axes)
    _legend_above(figure, axes, 2)
    return svg_element(figure, "ringing over the factor on the stiffness", COLOURS)


@figure_style(INK, SOFT, RULE)
def sweep_panel(analysis: SearchAnalysis, name: str) -> str:
    """Return the objectives over one gain, in multiples of their values at the best."""
    figure, axes = _panel(SMALL)
    points = analysis.sweeps[name]
    known = [point for point in points if point.measured is not None]
    centre = _value(analysis, name)
    reference = min(known, key=lambda point: abs(np.log(point.value / centre)), default=None)
    if reference is not None:
        for objective, colour, style in (("tracking", BEST, "-"), ("activity", FRONT, "--"), ("overshoot", START, ":")):
            values = _relative(known, reference, objective)
            if values is not None:
                axes.plot([point.value for point in known], values, style, color=colour, label=objective)
    for point in points:
        if point.rings:
            axes.axvline(point.value, color=BAD, linewidth=5.0, alpha=0.25)
    axes.axvline(centre, color=INK, linewidth=0.8)
    unit = analysis.search.space.units[name]
    label = f"{name.replace('_', ' ')}{'' if unit == '1' else f' [{unit}]'}"
    axes.set(xscale="log", yscale="log", xlabel=label, ylabel="multiple of the best")
    _plain_ticks(axes)
    axes.legend(loc="best")
    return svg_element(figure, f"objectives over {name}", COLOURS)


def _moving(analysis: SearchAnalysis) -> float:
    """Return a tenth more than the time in which the slowest response comes within 1 % of its end [s]."""
    last = 0.05
    for contender in (analysis.start, analysis.best):
        for axis, response in enumerate(contender.responses):
            if response is not None:
                error = response.error[:, axis] / response.step[axis]
                moving = np.flatnonzero(np.abs(error - error[-1]) > 0.01)
                last = max(last, float(response.time[moving[-1]]) if moving.size else 0.0)
    return 1.1 * last


def _value(analysis: SearchAnalysis, name: str) -> float:
    return analysis.search.space.rounded(analysis.best.record.values)[name]


def _relative(known: Sequence[SweepPoint], reference: SweepPoint, objective: str) -> list[float] | None:
    def of(measured: Measured | None) -> float | None:
        return None if measured is None else getattr(measured, objective)

    unit = of(reference.measured)
    values = [of(point.measured) for point in known]
    return [value / unit for value in values if value is not None] if unit else None


def _of(record: TrialRecord, objective: str) -> float:
    return float(getattr(record.report.measured, objective))


def _plane(records: Sequence[TrialRecord], x: str) -> tuple[list[float], list[float]]:
    return [_of(record, x) for record in records], [_of(record, "tracking") for record in records]


def _panel(size: tuple[float, float]) -> tuple[Figure, Axes]:
    figure = Figure(figsize=size)
    return figure, figure.subplots()


def _legend_above(figure: Figure, axes: Axes, columns: int) -> None:
    figure.legend(*axes.get_legend_handles_labels(), loc="outside upper left", ncols=columns, handlelength=1.6)


def _plain_ticks(axes: Axes) -> None:
    """Write 0.2 rather than a power of ten."""
    formatter: Any = mpl.ticker.FuncFormatter(lambda value, _: f"{value:g}")
    for side in (axes.xaxis, axes.yaxis):
        if side.get_scale() == "log":
            side.set_major_locator(mpl.ticker.LogLocator(subs=_subs(side), numticks=8))
            side.set_major_formatter(formatter)
            side.set_minor_formatter(mpl.ticker.NullFormatter())


def _subs(side: Any) -> tuple[float, ...]:
    """Return the digits that get a tick; an axis with a small range has more of them."""
    low, high = side.get_view_interval()
    return (1.0, 2.0, 5.0) if high / low > 8.0 else (1.0, 1.2, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0)


def count_limited_responses(contender: Contender) -> int:
    """Return how many of the six responses a limit of torque or speed changed, or diverged."""
    return sum(response is None or bool(response.active_limits) for response in contender.responses)
