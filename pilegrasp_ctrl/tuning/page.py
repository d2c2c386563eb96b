"""The page of a search, one file that opens offline: improvement, trade-offs and stability margin."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from .analysis import AXIS_NAMES, SWEEP, Contender, SearchAnalysis
from .figures import count_limited_responses, history, margin_panel, step_panel, sweep_panel, trade_off
from .objectives import LEVER, MEASURE_NAMES, UNITS, Measured, objective_names
from .stability_margin import MAX_STEP, OVERSHOOT, SWING, Margin
from .store import TrialRecord
from .trial import REQUIRED_MARGIN

_TEMPLATE = Path(__file__).with_name("page.html")


def page(analysis: SearchAnalysis, document: Mapping[str, Any], command: str) -> str:
    """Return the page as HTML.

    Args:
        analysis: Analysis of the search.
        document: JSON document of the command line.
        command: Command of the user.
    """
    search, names = analysis.search, objective_names(analysis.search.scenario)
    panels = [trade_off(analysis, name) for name in names[1:]]
    return Template(_TEMPLATE.read_text(encoding="utf-8")).substitute(
        title=escape(f"tune {search.scenario.name}"),
        scenario=escape(search.scenario.name),
        controller=escape(search.kind.replace("_", "-")),
        verdict=escape(_verdict(document, analysis.start)),
        rule=escape(analysis.rule[:1].upper() + analysis.rule[1:]),
        tiles=_tiles(analysis, names),
        gains=_gains_rows(analysis),
        trade_off="".join(map(_figure, panels)),
        history=_figure(history(analysis)),
        steps="".join(_figure(step_panel(analysis, axis)) for axis in range(len(AXIS_NAMES))),
        step_note=escape(_step_note(analysis)),
        margin=_figure(margin_panel(analysis)),
        margins=_margin_rows(analysis),
        required=f"{REQUIRED_MARGIN:g}",
        late=f" with torques {_periods(search.late)} late" if search.late else "",
        swing=f"{100 * SWING:g}",
        overshoot=f"{100 * OVERSHOOT:g}",
        lever=f"{1e3 * LEVER:g}",
        importance=_importance(analysis),
        sweeps="".join(_figure(sweep_panel(analysis, name)) for name in analysis.sweeps),
        widest=f"{SWEEP[-1]:g}",
        head="".join(f"<th>{escape(text)}</th>" for text in _columns(analysis)) + "<th class='words'>outcome</th>",
        rows="".join(_row(analysis, record) for record in analysis.records),
        counts=escape(_counts(document)),
        command=escape(command),
        best=escape(str(document["files"]["gains"])),
        use=escape(
            f"pilegrasp run {search.scenario.name} --set controller.kind={search.kind} "
            f"--set controller.gains={document['files']['gains']}"
        ),
        facts=_facts(analysis, document),
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


def _figure(svg: str) -> str:
    return f"<figure>{svg}</figure>"


def _tiles(analysis: SearchAnalysis, names: tuple[str, ...]) -> str:
    start, best = (contender.record.report.measured for contender in (analysis.start, analysis.best))
    tiles = [
        _tile(name, *(None if part is None else getattr(part, name) for part in (start, best)))
        for name in (*names, "position", "rotation")
    ]
    return "".join(tiles) + _margin_tile(analysis)


def _tile(measure: str, start: float | None, best: float | None) -> str:
    shown = [("–" if value is None else number(value)) for value in (start, best)]
    return (
        f'<div class="tile"><b>{escape(MEASURE_NAMES[measure])} <small>[{escape(UNITS[measure])}]</small></b>'
        f'<p><span class="start">{shown[0]}</span> → <span class="best">{shown[1]}</span></p></div>'
    )


def _margin_tile(analysis: SearchAnalysis) -> str:
    late = analysis.search.late
    values = [_margin_text(part.margins[late]) for part in (analysis.start, analysis.best)]
    return (
        '<div class="tile"><b>stability margin <small>[×]</small></b>'
        f'<p><span class="start">{values[0]}</span> → <span class="best">{values[1]}</span></p></div>'
    )


def _margin_text(margin: Margin) -> str:
    return f"{margin.factor:.2g}" if margin.limited else f"&gt; {margin.factor:g}"


def _gains_rows(analysis: SearchAnalysis) -> str:
    space = analysis.search.space
    rows = []
    for name, (low, high) in space.bounds.items():
        cells = [number(space.rounded(part.record.values)[name]) for part in (analysis.start, analysis.best)]
        unit = "" if space.units[name] == "1" else f" [{space.units[name]}]"
        rows.append(
            f"<tr><th>{escape(name.replace('_', ' ') + unit)}</th><td class='start'>{cells[0]}</td>"
            f"<td class='best'>{cells[1]}</td><td>{number(low)} – {number(high)}</td></tr>"
        )
    return "".join(rows)


def _margin_rows(analysis: SearchAnalysis) -> str:
    rows = []
    for late in analysis.start.margins:
        name = "as simulated" if late == 0 else f"torques {_periods(late)} later"
        cells = "".join(
            f"<td class='{kind if part.margins[late].factor >= 1.0 else 'bad'}'>{_margin_text(part.margins[late])}</td>"
            for kind, part in (("start", analysis.start), ("best", analysis.best))
        )
        rows.append(f"<tr><th>{name}</th>{cells}</tr>")
    return "".join(rows)


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


def _importance(analysis: SearchAnalysis) -> str:
    if not analysis.importance:
        return "<p class='note'>Too few completed trials to say which gain matters.</p>"
    bars = "".join(
        f"<tr><th>{escape(name.replace('_', ' '))}</th><td class='bar'><i style='width:{100 * share:.1f}%'></i></td>"
        f"<td>{100 * share:.0f} %</td></tr>"
        for name, share in analysis.importance.items()
    )
    return f"<table class='bars'>{bars}</table>"


def _columns(analysis: SearchAnalysis) -> list[str]:
    gains = [name.replace("_", " ") for name in analysis.search.space.bounds]
    measures = [f"{MEASURE_NAMES[name]} [{UNITS[name]}]" for name in objective_names(analysis.search.scenario)]
    return ["trial", *gains, *measures]


def _row(analysis: SearchAnalysis, record: TrialRecord) -> str:
    search, report = analysis.search, record.report
    values = search.space.rounded(record.values)
    cells = [f"<td>{number(values[name])}</td>" for name in search.space.bounds]
    cells += [f"<td>{_cell(report.measured, name)}</td>" for name in objective_names(search.scenario)]
    words = []
    if record.number == analysis.best.record.number:
        words.append("<b class='best'>best</b>")
    if record.number == 0:
        words.append("<b class='start'>start</b>")
    if any(record.number == other.number for other in analysis.front):
        words.append("on the front")
    if report.measured is None:
        words.append(f"<span class='bad'>failed: {escape(report.reason)}</span>")
    elif not report.feasible:
        words.append("<span class='bad'>rings too early</span>")
    return f"<tr><th>{record.number}</th>{''.join(cells)}<td class='words'>{', '.join(words)}</td></tr>"


def _cell(measured: Measured | None, name: str) -> str:
    value = None if measured is None else getattr(measured, name)
    return "–" if value is None else number(value)


def _counts(document: Mapping[str, Any]) -> str:
    trials = document["trials"]
    return (
        f"{trials['finished']} trials, {trials['failed']} of them not completed, {trials['with_margin']} with margin; "
        f"{trials['seconds']:.0f} s of work."
    )


def _facts(analysis: SearchAnalysis, document: Mapping[str, Any]) -> str:
    search = analysis.search
    controller, sensor = search.scenario.controller, search.scenario.sensor
    facts = {
        "seeds": ", ".join(map(str, search.seeds)),
        "robot and hand": f"{search.scenario.robot}, {search.scenario.hand}",
        "control": f"{controller.rate:g} Hz, {controller.solver}",
        "sensor": f"{sensor.cutoff:g} Hz low-pass, {sensor.force_noise:g} N noise; encoders exact",
        **document["versions"],
    }
    return "".join(f"<div><dt>{escape(name)}</dt><dd>{escape(text)}</dd></div>" for name, text in facts.items())
