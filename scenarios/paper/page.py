"""The ledger and the figures as one page that opens anywhere, offline."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from markupsafe import Markup

from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.scenarios.paper.experiment import Experiment
from pilegrasp_ctrl.scenarios.paper.repetition import DRAWS
from pilegrasp_ctrl.viewer.templates import render

MARKS = {
    "holds": ("good", "✓"),
    "fails": ("bad", "✗"),
    "undecided": ("open", "?"),
    "calibrated": ("fitted", "="),
    "reported": ("told", "·"),
    None: ("open", "…"),
}
"""CSS class and sign of each verdict; None stands for a row without its last attempt."""
STRANGE = 0.05
"""p-value below which a number of the paper and the model's are marked as different; chosen as usual."""


def results_page(document: Mapping[str, Any], experiments: Sequence[Experiment], evidence: Evidence) -> str:
    """Return the page as HTML.

    Args:
        document: Content of `claims.json`.
        experiments: Experiments with attempts to draw.
        evidence: Attempts of the experiments.
    """
    claims, nulls = document["claims"], document["nulls"]
    return str(
        render(
            "scenarios/paper/page.html",
            lead=_lead(document),
            draws=f"{DRAWS:,}",
            attempts=f"{document['attempts']:,}",
            conditions=document["conditions"],
            claims=list(map(_claim, claims)),
            nulls=list(map(_claim, nulls)),
            numbers=list(map(_number, document["paper_beside_model"])),
            figures=[_figure(part, evidence, document["figures"]) for part in experiments],
            command=document["command"],
            facts={
                "seeds from": document["seeds_from"],
                "processor time": f"{document['processor_hours']:.2f} h",
                **document["versions"],
            },
        )
    )


def _lead(document: Mapping[str, Any]) -> str:
    """Return the page's first sentence."""
    if document["missing"]:
        return f"{document['missing']:,} attempts are missing, so there is no verdict yet."
    counts = Counter(claim["verdict"] for claim in document["claims"])
    test = len(document["claims"]) - counts["calibrated"]
    parts = [
        f"{counts['holds']} of {test} claims that test the model hold",
        _counted(counts["fails"], "fails", "fail"),
        _counted(counts["undecided"], "is undecided", "are undecided"),
    ]
    fitted = _counted(counts["calibrated"], "claim shows", "claims show")
    expected = document["expected"]
    return (
        f"{'; '.join(parts)}. {fitted.capitalize()} what the model was fitted to. "
        f"A fresh study of the same size would find {expected['least']} to {expected['most']} that hold."
    )


def _counted(count: int, one: str, many: str) -> str:
    return f"{count or 'none'} {one if count == 1 else many}"


def _marked(judged: Mapping[str, Any]) -> dict[str, Any]:
    """Return a claim, or a part of one, with the CSS class and the sign of its verdict."""
    style, mark = MARKS[judged["verdict"]]
    return {**judged, "style": style, "mark": mark}


def _claim(claim: Mapping[str, Any]) -> dict[str, Any]:
    links = [(outcome, file) for outcome, file in claim["recordings"].items() if file is not None]
    said = claim["verdict"] or "no verdict"
    if claim["verdict"] == "calibrated":
        said = f"calibrated: {claim['outcome']}"
    repeats = claim["repeats"]
    chance = "" if repeats is None else f"repeats {100.0 * repeats:.0f} %"
    parts = list(map(_marked, claim["parts"]))
    return _marked(claim) | {"parts": parts, "links": links, "said": said, "chance": chance}


def _number(row: Mapping[str, Any]) -> dict[str, Any]:
    """Return a row of the table that compares a number of the paper with the model's."""
    if row["value"] is None:
        return {**row, "model": "not run", "interval": "", "style": "", "p_text": ""}
    form = "{:.1f}" if "mean" in row else "{:.0%}"
    low, high = (form.format(row[key]) for key in ("ci_low", "ci_high"))
    p = row["p"]
    return {
        **row,
        "model": f"{form.format(row['value'])} of {row['n']}",
        "interval": f"{low} – {high}",
        "style": "bad" if p < STRANGE else "",
        "p_text": f"{p:.2f}" if p >= 0.01 else f"{p:.0e}",
    }


def _figure(experiment: Experiment, evidence: Evidence, files: Mapping[str, Sequence[str]]) -> dict[str, Any]:
    return {
        "name": experiment.name,
        "title": experiment.title,
        "paper": experiment.paper,
        "element": Markup(experiment.figure_element(evidence)),
        "files": [(file, file.rpartition(".")[2].upper()) for file in files[experiment.name]],
    }
