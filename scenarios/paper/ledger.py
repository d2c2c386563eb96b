"""The ledger: every claim with its verdict and what it rests on, as one JSON document."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pilegrasp_ctrl.files import read_toml
from pilegrasp_ctrl.scenarios.paper import EXPLANATIONS
from pilegrasp_ctrl.scenarios.paper.claim import Claim, Finding
from pilegrasp_ctrl.scenarios.paper.claims import CLAIMS
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.scenarios.paper.examples import Example, examples


def ledger(evidence: Evidence) -> list[tuple[Claim, Finding, list[Example]]]:
    """Return every claim, what is found about it, and typical attempts."""
    return [(claim, claim.judge(evidence), examples(claim, evidence)) for claim in CLAIMS]


def explanations() -> dict[str, Mapping[str, str]]:
    """Return what experiments say about claims that do not hold: `text`, and `command` that shows it, by claim."""
    return read_toml(EXPLANATIONS)


def documents(entries: Sequence[tuple[Claim, Finding, list[Example]]]) -> list[dict[str, Any]]:
    """Return the ledger as JSON values."""
    known = explanations()
    return [_document(*entry, known.get(entry[0].name, {})) for entry in entries]


def _document(
    claim: Claim, finding: Finding, shown: Sequence[Example], explanation: Mapping[str, str]
) -> dict[str, Any]:
    told = explanation if finding.verdict != "holds" else {}
    links = {example.kind: example.page for example in shown}
    return {
        "id": claim.name,
        "where": claim.place,
        "claim": claim.text,
        "paper": claim.paper,
        "predicate": claim.predicate,
        "verdict": finding.verdict,
        "parts": [{"statement": part.statement, "verdict": part.verdict} for part in finding.parts],
        "conditions": {name: sample.as_dict() for name, sample in finding.samples.items()},
        "numbers": finding.numbers,
        "explanation": " ".join(filter(None, (finding.remark, told.get("text", "").strip()))),
        "shown_by": told.get("command", ""),
        "recordings": {kind: links.get(kind) for kind in ("success", "failure")},
    }
