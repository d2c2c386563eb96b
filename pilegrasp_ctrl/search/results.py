"""The results of a search: a scenario, a table of the candidates, a page, and the JSON document of the command line."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from ..exceptions import PilegraspError
from ..files import toml_text, write_output
from ..provenance import versions
from .ablation import MARGIN, Ablation
from .choice import RULE
from .evidence import lead_interval, mean_interval
from .race import ERROR, Candidate
from .run import SearchResult

PAGE = "index.html"
"""Name of the page in the folder of a search."""


def write_results(result: SearchResult, command: str) -> dict[str, Any]:
    """Write scenarios, table and pages to the folder; return the document that `--json` prints.

    The files are `best.toml`, `candidates.csv`, `winner.html`, `index.html`, and after an ablation `smallest.toml`.

    Args:
        result: Result of the search.
        command: Command of the user, for the page.

    Raises:
        ExportError: A file cannot be written.
    """
    from .page import page

    folder = result.search.folder
    write_output(folder / "best.toml", best_text(result).encode(), "scenario")
    if result.ablation is not None:
        write_output(folder / "smallest.toml", smallest_text(result, result.ablation).encode(), "scenario")
    write_output(folder / "candidates.csv", candidates_csv(result).encode(), "table")
    shown = _write_recording(result)
    document = as_document(result, shown)
    write_output(folder / PAGE, page(result, document, command).encode("utf-8", errors="replace"), "page")
    return document


def best_text(result: SearchResult) -> str:
    """Return the winner's scenario as TOML, with what was found at its head."""
    judgement = result.judgement
    lines = [
        f"Candidate {result.winner.number} of {len(result.race.candidates)}; "
        f"objective: {result.search.objective.name}.",
        f"On {judgement.n} fresh seeds: {judgement.winner:.3g}, the start {judgement.start:.3g}; "
        f"verdict: {judgement.verdict}.",
    ]
    return _scenario_text(result, result.winner, lines)


def smallest_text(result: SearchResult, ablation: Ablation) -> str:
    """Return the scenario with the smallest change that is not worse than the winner, as TOML."""
    last = next((step for step in reversed(ablation.steps) if step.chosen), None)
    lines = [f"Changes of the start: {', '.join(ablation.smallest) or 'none'}."]
    if last is not None and last.value is not None:
        lines.append(
            f"On {result.judgement.n} fresh seeds: {last.value:.3g}, the winner {result.judgement.winner:.3g}, "
            f"gain {100 * last.low:+.0f} to {100 * last.high:+.0f} %."
        )
    smallest = Candidate(-1, {**result.search.space.start, **ablation.smallest})
    return _scenario_text(result, smallest if ablation.smallest else result.race.candidates[0], lines)


def _scenario_text(result: SearchResult, candidate: Candidate, lines: Sequence[str]) -> str:
    """Return a candidate's scenario as TOML, with lines at its head."""
    worlds = result.search.worlds
    scenario = result.search.condition(candidate, worlds[0] if len(worlds) == 1 else {}).placed
    scenario = scenario.model_copy(update={"summary": f"Found by pilegrasp search from {scenario.name}."[:200]})
    return "".join(f"# {line}\n" for line in lines) + toml_text(scenario.model_dump(mode="json"))


def _write_recording(result: SearchResult) -> Path | None:
    """Write the page of the winner's recording beside that of the start; None if there is no recording."""
    from ..recording import Recording
    from ..viewer import write

    if not result.recordings:
        return None
    try:
        first, *others = map(Recording.load, result.recordings)
    except PilegraspError:
        return None
    output = result.search.folder / "winner.html"
    write(first, output, beside=others[0] if others else None)
    return output


def state_of(result: SearchResult, candidate: Candidate) -> str:
    """Return the word for what became of a candidate."""
    if candidate.impossible:
        return "cannot run"
    if candidate is result.winner:
        return "winner"
    if candidate.eliminated_by is not None:
        return "eliminated"
    if candidate in result.tied:
        return "tied"
    return "not apart" if candidate.n == result.winner.n else "left behind"


def candidates_csv(result: SearchResult) -> str:
    """Return every candidate as one line of CSV."""
    keys = [parameter.key for parameter in result.search.space.parameters]
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    found = ["seeds", result.search.objective.name, "low", "high", "picks_an_hour", "peak_force_N", "distance"]
    writer.writerow(["candidate", "state", *keys, *found, "eliminated_by", "reason"])
    for row in candidate_rows(result):
        cells = [_cell(row["values"][key]) for key in keys]
        low, high = row["interval"] or (None, None)
        others = [row[name] for name in ("picks_an_hour", "peak_force", "distance", "eliminated_by", "reason")]
        writer.writerow([row["candidate"], row["state"], *cells, row["seeds"], row["value"], low, high, *others])
    return buffer.getvalue()


def _cell(value: Any) -> Any:
    return json.dumps(value) if isinstance(value, list | dict) else value


def candidate_rows(result: SearchResult) -> list[dict[str, Any]]:
    """Return what is known of every candidate, as JSON values."""
    rows = []
    for candidate in result.race.candidates:
        samples = candidate.samples
        worst = None if samples is None else samples.score[:, int(samples.score.mean(axis=0).argmin())]
        timed = result.search.objective.timed
        rows.append(
            {
                "candidate": candidate.number,
                "state": state_of(result, candidate),
                "values": dict(candidate.values),
                "seeds": candidate.n,
                "value": result.race.value(candidate),
                "interval": None if timed or worst is None else list(mean_interval(worst, ERROR)),
                "picks_an_hour": 0.0 if samples is None else samples.picks_an_hour,
                "peak_force": 0.0 if samples is None else samples.median_peak,
                "distance": result.search.space.distance(candidate.values),
                "eliminated_by": candidate.eliminated_by,
                "reason": candidate.impossible,
            }
        )
    return rows


def undecided(result: SearchResult) -> list[dict[str, Any]]:
    """Return the candidates that may be better than the winner, with an interval of the winner's lead over each.

    The lead is a difference of scores on the seeds after those of the proposals; with a timed objective it is that of
    the scores less their times at the leader's rate, halved.
    """
    found = []
    for other in result.race.alive:
        if other is result.winner or other.samples is None or result.winner.samples is None:
            continue
        rate, first = result.race.rate(), result.race.first
        rows = result.search.objective.leads(result.winner.samples.part(first), other.samples.part(first), rate)
        low, high = lead_interval(rows[0][0], ERROR) if len(rows) == 1 else (-1.0, 1.0)
        found.append({"candidate": other.number, "seeds": other.n, "lead_low": low, "lead_high": high})
    return found


def _ablation(ablation: Ablation) -> dict[str, Any]:
    return {
        "margin": MARGIN,
        "smallest": dict(ablation.smallest),
        "steps": [{**asdict(step), "kept": dict(step.kept)} for step in ablation.steps],
    }


def as_document(result: SearchResult, shown: Path | None) -> dict[str, Any]:
    """Return the search and its result as JSON values."""
    search, race, folder = result.search, result.race, result.search.folder
    changed = {} if result.winner.number == 0 else dict(result.winner.values)
    files = {
        "scenario": str(folder / "best.toml"),
        "candidates": str(folder / "candidates.csv"),
        "page": str(folder / PAGE),
        "store": str(folder / "study.db"),
    }
    if result.ablation is not None:
        files["smallest"] = str(folder / "smallest.toml")
    return {
        "scenario": search.scenario.name,
        "objective": search.objective.name,
        "over": [parameter.key for parameter in search.space.parameters],
        "worlds": [dict(world) for world in search.worlds],
        "attempts": race.spent,
        "candidates": candidate_rows(result),
        "start": dict(search.space.start),
        "winner": {"candidate": result.winner.number, "set": changed},
        "tied": [candidate.number for candidate in result.tied],
        "undecided": undecided(result),
        "rule": RULE,
        "judgement": {**asdict(result.judgement), "worlds": list(result.judgement.worlds)},
        "verdict": result.judgement.verdict,
        "ablation": None if result.ablation is None else _ablation(result.ablation),
        "versions": versions("optuna"),
        "files": files | ({"recording": str(shown)} if shown else {}),
    }
