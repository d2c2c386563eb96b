"""The page of a search, one file that opens offline: improvement, trade-offs and stability margin."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from markupsafe import Markup

from ..viewer.templates import render
from .analysis import AXIS_NAMES, SWEEP, Contender, SearchAnalysis
from .figures import count_limited_responses, history, margin_panel, step_panel, sweep_panel, trade_off
from .objectives import LEVER, MEASURE_NAMES, UNITS, Measured, objective_names
from .stability_margin import MAX_STEP, OVERSHOOT, SWING, Margin
from .store import TrialRecord
from .trial import REQUIRED_MARGIN


def page(analysis: SearchAnalysis, document: Mapping[str, Any], command: str) -> str:
    """Return the page as HTML.

    Args:
        analysis: Analysis of the search.
        document: JSON document of the command line.
        command: Command of the user.
    """
    search, names = analysis.search, objective_names(analysis.search.scenario)
    panels = [trade_off(analysis, name) for name in names[1:]] + [history(analysis)]
    best = str(document["files"]["gains"])
    return str(
        render(
            "tuning/page.html",
            title=f"tune {search.scenario.name}",
            scenario=search.scenario.name,
            controller=search.kind.replace("_", "-"),
            verdict=_verdict(document, analysis.start),
            rule=analysis.rule[:1].upper() + analysis.rule[1:],
            tiles=[*_tiles(analysis, names), _margin_tile(analysis)],
            gains=_gains_rows(analysis),
            trade_off=list(map(Markup, panels)),
            steps=[Markup(step_panel(analysis, axis)) for axis in range(len(AXIS_NAMES))],
            step_note=_step_note(analysis),
            margin=Markup(margin_panel(analysis)),
            margins=_margin_rows(analysis),
            required=f"{REQUIRED_MARGIN:g}",
            late=f" with torques {_periods(search.late)} late" if search.late else "",
            swing=f"{100 * SWING:g}",
            overshoot=f"{100 * OVERSHOOT:g}",
            lever=f"{1e3 * LEVER:g}",
            importance=[(name.replace("_", " "), 100 * share) for name, share in analysis.importance.items()],
            sweeps=[Markup(sweep_panel(analysis, name)) for name in analysis.sweeps],
            widest=f"{SWEEP[-1]:g}",
            head=_columns(analysis),
            rows=[_row(analysis, record) for record in analysis.records],
            counts=_counts(document),
            command=command,
            use=(
                f"pilegrasp run {search.scenario.name} --set controller.kind={search.kind} "
                f"--set controller.gains={best}"
            ),
            facts=_facts(analysis, document),
        )
    )


def number(value: float) -> str:
    """Return three digits, without an exponent from 0.001 to 100000."""
    if value == 0.0 or not 1e-3 <= abs(value) < 1e5:
        return f"{value:.3g}"
    return f"{value:.{max(0, 2 - int(np.floor(np.log10(abs(value)))))}f}"


def _verdict(document: Mapping[str, Any], start: Contender) -> str:
    improvement = document["improvement"].get("tracking")
    if improvement is None:
        return "The start could not be measured, so the best cannot be compared with it."
    if document["best"]["trial"] == 0:
        return "Nothing better than the start was found."
    factor = number(improvement) if improvement >= 1.0 else number(1.0 / improvement)
    than = (
        "than with the start gains"
        if start.record.report.feasible
        else "than with the start gains, which ring too early"
    )
    return f"Tracking error {factor} times {'smaller' if improvement >= 1.0 else 'larger'} {than}."


def _tiles(analysis: SearchAnalysis, names: tuple[str, ...]) -> list[dict[str, str]]:
    start, best = (contender.record.report.measured for contender in (analysis.start, analysis.best))
    return [
        {"name": MEASURE_NAMES[name], "unit": UNITS[name], "start": _cell(start, name), "best": _cell(best, name)}
        for name in (*names, "position", "rotation")
    ]


def _margin_tile(analysis: SearchAnalysis) -> dict[str, str]:
    start, best = (_margin_text(part.margins[analysis.search.late]) for part in (analysis.start, analysis.best))
    return {"name": "stability margin", "unit": "×", "start": start, "best": best}


def _margin_text(margin: Margin) -> str:
    return f"{margin.factor:.2g}" if margin.limited else f"> {margin.factor:g}"


def _gains_rows(analysis: SearchAnalysis) -> list[dict[str, str]]:
    space = analysis.search.space
    rows = []
    for name, (low, high) in space.bounds.items():
        start, best = (number(space.rounded(part.record.values)[name]) for part in (analysis.start, analysis.best))
        unit = "" if space.units[name] == "1" else f" [{space.units[name]}]"
        words = name.replace("_", " ") + unit
        rows.append({"name": words, "start": start, "best": best, "low": number(low), "high": number(high)})
    return rows


def _margin_rows(analysis: SearchAnalysis) -> list[dict[str, Any]]:
    rows = []
    for late in analysis.start.margins:
        cells = [
            {
                "style": kind if part.margins[late].factor >= 1.0 else "bad",
                "words": _margin_text(part.margins[late]),
            }
            for kind, part in (("start", analysis.start), ("best", analysis.best))
        ]
        rows.append({"name": "as simulated" if late == 0 else f"torques {_periods(late)} later", "cells": cells})
    return rows


def _periods(late: int) -> str:
    return f"{late} control period{'s' if late > 1 else ''}"


def _step_note(analysis: SearchAnalysis) -> str:
    text = (
        f"The reference jumps by {1e3 * MAX_STEP[0]:g} mm or {1e3 * MAX_STEP[1]:g} mrad, one axis at a time. "
        "A response should arrive at 1; joint friction holds an arm whose response stops short of it."
    )
    for name, part in (("start", analysis.start), ("best", analysis.best)):
        if count := count_limited_responses(part):
            text += f" A limit of torque or speed bent {count} of the six responses of the {name}."
    return text


def _columns(analysis: SearchAnalysis) -> list[str]:
    gains = [name.replace("_", " ") for name in analysis.search.space.bounds]
    measures = [f"{MEASURE_NAMES[name]} [{UNITS[name]}]" for name in objective_names(analysis.search.scenario)]
    return ["trial", *gains, *measures]


def _row(analysis: SearchAnalysis, record: TrialRecord) -> dict[str, Any]:
    search, report = analysis.search, record.report
    values = search.space.rounded(record.values)
    cells = [number(values[name]) for name in search.space.bounds]
    cells += [_cell(report.measured, name) for name in objective_names(search.scenario)]
    notes = []
    if record.number == analysis.best.record.number:
        notes.append(("best", "best"))
    if record.number == 0:
        notes.append(("start", "start"))
    if any(record.number == other.number for other in analysis.front):
        notes.append(("", "on the front"))
    if report.measured is None:
        notes.append(("bad", f"failed: {report.reason}"))
    elif not report.feasible:
        notes.append(("bad", "rings too early"))
    return {"number": record.number, "cells": cells, "notes": notes}


def _cell(measured: Measured | None, name: str) -> str:
    value = None if measured is None else getattr(measured, name)
    return "–" if value is None else number(value)


def _counts(document: Mapping[str, Any]) -> str:
    trials = document["trials"]
    return (
        f"{trials['finished']} trials, {trials['failed']} of them not completed, {trials['with_margin']} with margin; "
        f"{trials['seconds']:.0f} s of work."
    )


def _facts(analysis: SearchAnalysis, document: Mapping[str, Any]) -> dict[str, str]:
    search = analysis.search
    controller, sensor = search.scenario.controller, search.scenario.sensor
    return {
        "seeds": ", ".join(map(str, search.seeds)),
        "robot and hand": f"{search.scenario.robot}, {search.scenario.hand}",
        "control": f"{controller.rate:g} Hz, {controller.solver}",
        "sensor": f"{sensor.cutoff:g} Hz low-pass, {sensor.force_noise:g} N noise; encoders exact",
        **document["versions"],
    }
