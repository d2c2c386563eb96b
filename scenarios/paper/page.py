"""The ledger and the figures as one page that opens anywhere, offline."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from string import Template
from typing import Any

from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.scenarios.paper.experiment import Experiment

_TEMPLATE = Path(__file__).with_name("page.html")
MARKS = {"holds": ("good", "✓"), "fails": ("bad", "✗"), "not decided": ("open", "?")}
"""CSS class and sign of each verdict."""


def results_page(document: Mapping[str, Any], experiments: Sequence[Experiment], evidence: Evidence) -> str:
    """Return the page as HTML.

    Args:
        document: Content of `claims.json`.
        experiments: Experiments with attempts to draw.
        evidence: Attempts of the experiments.
    """
    claims = document["claims"]
    counts = Counter(claim["verdict"] for claim in claims)
    return Template(_TEMPLATE.read_text(encoding="utf-8")).substitute(
        holds=counts["holds"],
        claims=len(claims),
        fails=_counted(counts["fails"], "fails", "fail"),
        open=_counted(counts["not decided"], "undecided", "undecided"),
        attempts=f"{document['attempts']:,}",
        conditions=document["conditions"],
        tiles="".join(map(_tile, claims)),
        cards="".join(map(_card, claims)),
        figures="".join(_figure(part, evidence, document["figures"]) for part in experiments),
        command=escape(document["command"]),
        facts=_facts(document),
    )


def _counted(count: int, one: str, many: str) -> str:
    return f"{count or 'none'} {one if count == 1 else many}"


def _tile(claim: Mapping[str, Any]) -> str:
    style, mark = MARKS[claim["verdict"]]
    return (
        f'<a class="tile {style}" href="#{claim["id"]}" title="{escape(claim["claim"])}">'
        f"<b>{claim['id']}</b><i>{mark}</i><span>{escape(claim['verdict'])}</span></a>"
    )


def _card(claim: Mapping[str, Any]) -> str:
    style, _ = MARKS[claim["verdict"]]
    explained = f"<p>{escape(claim['explanation'])}</p>" if claim["explanation"] else ""
    shown_by = f"<code>{escape(claim['shown_by'])}</code>" if claim["shown_by"] else ""
    return (
        f'<article id="{claim["id"]}" class="{style}"><header><b>{claim["id"]}</b><h3>{escape(claim["claim"])}</h3>'
        f'<span class="badge">{escape(claim["verdict"])}</span></header>'
        f"<dl><dt>the paper, {escape(claim['where'])}</dt><dd>{escape(claim['paper'])}</dd>"
        f"<dt>judged by</dt><dd>{escape(claim['predicate'])}</dd></dl>"
        f"<ul>{''.join(map(_part, claim['parts']))}</ul>{explained}{shown_by}{_rates(claim)}{_links(claim)}</article>"
    )


def _part(part: Mapping[str, str]) -> str:
    style, mark = MARKS[part["verdict"]]
    return f'<li class="{style}"><i aria-label="{part["verdict"]}">{mark}</i>{escape(part["statement"])}</li>'


def _rates(claim: Mapping[str, Any]) -> str:
    """Return the conditions with bars: the rate, and its interval as a paler range."""
    rows = []
    for name, sample in claim["conditions"].items():
        if sample["n"]:
            low, high, rate = (100.0 * sample[key] for key in ("ci_low", "ci_high", "rate"))
            bar = (
                f'<span class="bar"><u style="left:{low:.1f}%;width:{high - low:.1f}%"></u>'
                f'<s style="left:{rate:.1f}%"></s></span>'
            )
            cells = f"<td>{bar}</td><td>{sample['successes']} of {sample['n']}</td><td>{low:.0f} – {high:.0f} %</td>"
        else:
            cells = "<td></td><td>not run</td><td></td>"
        errors = f" <em>{sample['errors']} errors</em>" if sample["errors"] else ""
        rows.append(f"<tr><th>{escape(name)}{errors}</th>{cells}</tr>")
    return (
        f"<details><summary>{len(rows)} condition{'s' if len(rows) > 1 else ''}</summary><div class='scroll'>"
        f"<table><thead><tr><th></th><th>success, 95 % interval</th><th></th><th></th></tr></thead>"
        f"<tbody>{''.join(rows)}</tbody></table></div></details>"
    )


def _links(claim: Mapping[str, Any]) -> str:
    links = [
        f'<a href="{escape(file)}">▶ a typical {outcome}</a>'
        for outcome, file in claim["recordings"].items()
        if file is not None
    ]
    return f'<p class="links">{"".join(links)}</p>' if links else ""


def _figure(experiment: Experiment, evidence: Evidence, files: Mapping[str, Sequence[str]]) -> str:
    links = ", ".join(f'<a href="{file}">{file.rpartition(".")[2].upper()}</a>' for file in files[experiment.name])
    return (
        f'<section id="{experiment.name}"><h3>{escape(experiment.title)}</h3><div class="scroll">'
        f"<figure>{experiment.figure_element(evidence)}</figure></div>"
        f'<p class="note"><b>The paper:</b> {escape(experiment.paper)} <span class="files">{links}</span></p></section>'
    )


def _facts(document: Mapping[str, Any]) -> str:
    facts = {
        "seeds from": document["seeds_from"],
        "processor time": f"{document['processor_hours']:.2f} h",
        **document["versions"],
    }
    return "".join(
        f"<div><dt>{escape(str(name))}</dt><dd>{escape(str(value))}</dd></div>" for name, value in facts.items()
    )
