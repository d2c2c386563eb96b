"""The results of a search: the gains, a table of the trials, a page, and the JSON document of the command line."""

from __future__ import annotations

import csv
import io
from typing import Any

from ..files import write_output
from ..provenance import versions
from ..tasks.gains import load_gains
from .analysis import Contender, SearchAnalysis
from .gain_space import gains_table, gains_text
from .objectives import UNITS, objective_names
from .page import page
from .search import Search
from .stability_margin import Margin


def write_results(analysis: SearchAnalysis, command: str) -> dict[str, Any]:
    """Write `best.toml`, `trials.csv` and `index.html`, and return the document that `--json` prints.

    Args:
        analysis: Analysis of the search.
        command: Command of the user, for the page.

    Raises:
        ExportError: A file cannot be written.
    """
    folder = analysis.search.folder
    write_output(folder / "best.toml", best_text(analysis).encode(), "gains")
    write_output(folder / "trials.csv", trials_csv(analysis).encode(), "table")
    document = as_document(analysis)
    write_output(folder / "index.html", page(analysis, document, command).encode("utf-8", errors="replace"), "page")
    return document


def best_text(analysis: SearchAnalysis) -> str:
    """Return the text of the file of the proposed gains, with their origin at its head."""
    search, best = analysis.search, analysis.best
    measured = best.record.report.measured
    facts = [] if measured is None else [f"{name} {value:.3g} {UNITS[name]}" for name, value in _facts(measured)]
    comment = (
        f"Gains found by pilegrasp tune for {search.scenario.name}, {search.kind}: trial {best.record.number} of "
        f"{len(analysis.records)}.\n{', '.join(facts)}.\n"
        f"Stiffness can grow by a factor of {best.margins[search.late]} before the loop rings."
    )
    return gains_text(best.gains, comment)


def trials_csv(analysis: SearchAnalysis) -> str:
    """Return every trial as one line of CSV; the names of the columns contain the units."""
    names = [*analysis.search.space.bounds]
    measures = [*UNITS]
    columns = ["trial", "state", *names]
    columns += [f"{name}_{UNITS[name].replace('%', 'percent')}" for name in measures]
    columns += ["ringing", "ringing_at_margin", "on_front", "chosen", "success", "wall_time_s", "gains", "reason"]
    front = {record.number for record in analysis.front}
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(columns)
    for record in analysis.records:
        report = record.report
        values = analysis.search.space.rounded(record.values)
        cells = [None] * len(measures) if report.measured is None else [getattr(report.measured, x) for x in measures]
        ringing = report.ringing or (None, None)
        file = analysis.search.gains_file(record.number).relative_to(analysis.search.folder)
        writer.writerow(
            [
                record.number,
                state(record.report.measured is not None, report.feasible),
                *(values[name] for name in names),
                *cells,
                *ringing,
                int(record.number in front),
                int(record.number == analysis.best.record.number),
                report.success,
                report.wall_time,
                file,
                report.reason,
            ]
        )
    return buffer.getvalue()


def as_document(analysis: SearchAnalysis) -> dict[str, Any]:
    """Return the search and its result as JSON values."""
    search, records = analysis.search, analysis.records
    start, best = analysis.start.record.report.measured, analysis.best.record.report.measured
    names = objective_names(search.scenario)
    improvement = {
        name: getattr(start, name) / getattr(best, name)
        for name in names
        if start is not None and best is not None and getattr(best, name)
    }
    failed = [record for record in records if record.report.measured is None]
    folder = search.folder
    return {
        "scenario": search.scenario.name,
        "controller": search.kind,
        "seeds": list(search.seeds),
        "trials": {
            "finished": len(records),
            "failed": len(failed),
            "with_margin": sum(record.report.feasible for record in records),
            "seconds": sum(record.report.wall_time for record in records),
        },
        "objectives": {name: UNITS[name] for name in names},
        "start": _contender(analysis.start, search),
        "best": _contender(analysis.best, search),
        "improvement": improvement,
        "rule": analysis.rule,
        "importance": analysis.importance,
        "versions": versions("optuna"),
        "files": {
            "gains": str(folder / "best.toml"),
            "trials": str(folder / "trials.csv"),
            "page": str(folder / "index.html"),
            "store": str(folder / "tuning.db"),
        },
    }


def state(completed: bool, feasible: bool) -> str:
    """Return the word for the result of a trial: ok, rings or failed."""
    return ("ok" if feasible else "rings") if completed else "failed"


def _facts(measured: Any) -> list[tuple[str, float]]:
    return [(name, value) for name in UNITS if (value := getattr(measured, name)) is not None]


def _contender(contender: Contender, search: Search) -> dict[str, Any]:
    report = contender.record.report
    return {
        "trial": contender.record.number,
        "measured": None if report.measured is None else report.measured.as_dict(),
        "reason": report.reason,
        "gains": gains_table(load_gains(search.gains_file(contender.record.number))),
        "margin": _margin(contender.margins[search.late]),
        "margin_by_periods_late": {str(late): _margin(margin) for late, margin in contender.margins.items()},
    }


def _margin(margin: Margin) -> dict[str, Any]:
    return {"factor": margin.factor, "at_least": not margin.limited}
