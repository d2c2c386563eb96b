"""The page of a search, one file that opens offline: verdict, winner, parameters, and what was not decided."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from markupsafe import Markup

from ..viewer.templates import render
from .ablation import MARGIN, Ablation
from .figures import over_pair, over_parameter, pairs
from .judgement import WORTH
from .race import ERROR
from .run import SearchResult

VERDICTS = {
    "better": "The search found a better strategy.",
    "worse": "The winner of the search is worse than the start: it was lucky on the seeds of the search.",
    "nothing found": "The search found nothing that is worth a change.",
    "undecided": "Undecided: the winner may be better than the start, or not.",
}
"""Sentence for each verdict."""

_FOUND = ("seeds", "value", "interval", "picks an hour", "peak force [N]")


def page(result: SearchResult, document: Mapping[str, Any], command: str) -> str:
    """Return the page as HTML.

    Args:
        result: Result of the search.
        document: JSON document of the command line.
        command: Command of the user.
    """
    search, judgement = result.search, result.judgement
    parameters = search.space.parameters
    same = result.winner.number == 0
    best = str(document["files"]["scenario"])
    return str(
        render(
            "search/page.html",
            title=f"search {document['scenario']}",
            scenario=document["scenario"],
            objective=search.objective.words,
            verdict="No candidate beat the start." if same else VERDICTS[judgement.verdict],
            tiles=_tiles(result),
            worlds=_worlds(result),
            values=_values(result),
            rule=document["rule"],
            ablation=None if result.ablation is None else _ablation(result, result.ablation),
            use=f"pilegrasp run {best}",
            shown="winner.html" if "recording" in document["files"] else "",
            over=[Markup(over_parameter(result, parameter)) for parameter in parameters],
            pairs=[Markup(over_pair(result, *pair)) for pair in pairs(parameters)],
            all_pairs=len(parameters) * (len(parameters) - 1) // 2,
            undecided=[_undecided(row) for row in document["undecided"] if row["seeds"] >= result.winner.n],
            behind=_behind([row["seeds"] for row in document["undecided"] if row["seeds"] < result.winner.n]),
            impossible=[row for row in document["candidates"] if row["reason"]],
            head=["candidate", *(parameter.key for parameter in parameters), *_FOUND],
            rows=[_row(row) for row in document["candidates"]],
            counts=f"{len(result.race.candidates)} candidates, {result.race.spent} attempts in the race, "
            f"{judgement.n} fresh seeds for the judgement.",
            first=result.race.first,
            error=f"{100 * ERROR:g}",
            worth=f"{100 * WORTH:g}",
            command=command,
            facts={"race on seeds": f"{search.seeds.start} and up", "judged on seeds": _seeds(search.judging)}
            | document["versions"],
        )
    )


def text_of(value: Any) -> str:
    """Return a value of a key as text."""
    if value is None:
        return "–"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _seeds(seeds: range) -> str:
    return f"{seeds.start} to {seeds.stop - 1}"


def _percent(value: float) -> str:
    return f"{100 * value:.0f} %"


def _tiles(result: SearchResult) -> list[dict[str, str]]:
    judgement, timed = result.judgement, result.search.objective.timed
    show = (lambda value: f"{value:.0f}") if timed else _percent
    gain = f"{100 * judgement.low:+.0f} to {100 * judgement.high:+.0f} {'%' if timed else 'points'}"
    return [
        {
            "name": result.search.objective.words,
            "unit": "",
            "start": show(judgement.start),
            "best": show(judgement.winner),
        },
        {"name": "gain, 95 % interval", "unit": "", "start": "", "best": gain},
    ]


def _worlds(result: SearchResult) -> list[dict[str, Any]]:
    rows = []
    for values, row in zip(result.search.worlds, result.judgement.worlds, strict=True):
        ends = [f"{_percent(low)} to {_percent(high)}" for low, high in (row["start_interval"], row["winner_interval"])]
        rows.append(
            {
                "name": ", ".join(f"{key} = {text_of(value)}" for key, value in values.items()) or "as the scenario",
                "start": f"{row['start']} of {row['n']} ({ends[0]})",
                "winner": f"{row['winner']} of {row['n']} ({ends[1]})",
                "only": f"{row['winner_only']} and {row['start_only']}",
                "p": f"{row['p']:.2g}",
            }
        )
    return rows


def _values(result: SearchResult) -> list[dict[str, str]]:
    start, winner = result.search.space.start, result.winner.values
    return [{"name": key, "start": text_of(start[key]), "best": text_of(winner[key])} for key in start]


def _ablation(result: SearchResult, ablation: Ablation) -> dict[str, Any]:
    """Return what the page says of an ablation."""
    timed = result.search.objective.timed
    rows = []
    for step in ablation.steps:
        value = "cannot run" if step.value is None else f"{step.value:.0f}" if timed else _percent(step.value)
        verdict = "goes on" if step.chosen else "not worse" if step.suffices else "worse, or not decided"
        rows.append(
            {
                "round": step.round,
                "back": step.back,
                "kept": ", ".join(step.kept) or "none",
                "value": value,
                "gain": "–" if step.value is None else f"{100 * step.low:+.0f} to {100 * step.high:+.0f}",
                "verdict": verdict,
                "style": "best" if step.chosen else "" if step.suffices else "bad",
            }
        )
    kept = [f"{key} = {text_of(value)}" for key, value in ablation.smallest.items()]
    return {"rows": rows, "kept": ", ".join(kept), "margin": f"{100 * MARGIN:g}"}


def _undecided(row: Mapping[str, Any]) -> dict[str, Any]:
    lead = f"{100 * row['lead_low']:+.0f} to {100 * row['lead_high']:+.0f}"
    return {"candidate": row["candidate"], "seeds": row["seeds"], "lead": lead}


def _behind(seeds: Sequence[int]) -> str:
    """Return the sentence about candidates that are left with fewer seeds than the winner."""
    if not seeds:
        return ""
    others = "1 other candidate was" if len(seeds) == 1 else f"{len(seeds)} other candidates were"
    return (
        f"{others} left behind after {min(seeds)} to {max(seeds)} seeds, because others did better on them. "
        "Nothing is sure about them; a larger budget decides more."
    )


def _row(row: Mapping[str, Any]) -> dict[str, Any]:
    interval = "–" if row["interval"] is None else " to ".join(f"{end:.2f}" for end in row["interval"])
    cells = [*map(text_of, row["values"].values()), str(row["seeds"]), f"{row['value']:.3g}", interval]
    cells += [f"{row['picks_an_hour']:.0f}", f"{row['peak_force']:.1f}"]
    note = row["reason"] or (f"by {row['eliminated_by']}" if row["eliminated_by"] is not None else "")
    style = {"winner": "best", "eliminated": "bad", "cannot run": "bad"}.get(row["state"], "")
    return {"number": row["candidate"], "cells": cells, "notes": [(style, f"{row['state']} {note}".strip())]}
