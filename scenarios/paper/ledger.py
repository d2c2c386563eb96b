"""The ledger: every claim with its verdict, its numbers, and typical attempts, as one JSON document."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pilegrasp_ctrl.exceptions import SimulationError
from pilegrasp_ctrl.files import RECORDINGS, read_toml
from pilegrasp_ctrl.scenarios.paper import claims_mechanism, claims_nulls, claims_objects, claims_piles
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.scenarios.paper.judgement import Claim, Finding
from pilegrasp_ctrl.scenarios.paper.repetition import DRAWS, Repetition, repetition
from pilegrasp_ctrl.scenarios.paper.verdicts import Judged, combine_outcomes, combine_verdicts, second_pass
from pilegrasp_ctrl.study.attempt import AttemptRow
from pilegrasp_ctrl.study.condition import Condition
from pilegrasp_ctrl.study.own_files import is_own, note_own
from pilegrasp_ctrl.study.store import StudyStore

CLAIMS = (*claims_objects.CLAIMS, *claims_piles.CLAIMS, *claims_mechanism.CLAIMS)
"""All claims of the paper, in the order of their names."""
ROWS = (*CLAIMS, *claims_nulls.NULLS)
"""All rows of the ledger: the claims, and the null models."""
EXPLANATIONS = Path(__file__).with_name("explanations.toml")
"""File of explanations by claim, for results that differ from the paper: `text`, and the `command` that shows it."""


@dataclass(frozen=True, slots=True)
class Example:
    """A typical attempt.

    Attributes:
        row: Row of the attempt.
        outcome: Outcome of the attempt, "success" or "failure".
    """

    row: AttemptRow
    outcome: str

    @property
    def page(self) -> str:
        """Path of the page below the study's folder."""
        return f"{RECORDINGS}/{self.row.config_hash}-{self.row.seed}.html"


@dataclass(frozen=True, slots=True)
class Entry:
    """A row of the ledger.

    Attributes:
        claim: Claim of the paper, or null model.
        finding: Finding from the evidence.
        parts: Statements, judged together with those of all rows.
        examples: Typical attempts.
        repeats: Probability that a fresh study of the same size repeats the outcome; None while attempts are missing.
    """

    claim: Claim
    finding: Finding
    parts: tuple[Judged, ...]
    examples: list[Example]
    repeats: float | None

    @property
    def complete(self) -> bool:
        """Whether every attempt of the ledger is there, so that there is a verdict."""
        return self.repeats is not None

    def as_dict(self, explanation: Mapping[str, str]) -> dict[str, Any]:
        """Return plain JSON values; the explanation is given only for a row that does not hold."""
        claim, finding = self.claim, self.finding
        verdict = combine_verdicts(self.parts)
        shown = explanation if self.complete and verdict not in ("holds", "reported") else {}
        pages = {example.outcome: example.page for example in self.examples}
        reported = verdict == "reported"
        return {
            "id": claim.name,
            "where": claim.place,
            "claim": claim.text,
            "paper": claim.paper,
            "predicate": claim.predicate,
            "verdict": verdict if self.complete else None,
            "outcome": combine_outcomes(self.parts) if self.complete and not reported else None,
            "repeats": None if reported else self.repeats,
            "parts": [part.as_dict(self.complete) for part in self.parts],
            "conditions": {name: sample.as_dict() for name, sample in finding.samples.items()},
            "numbers": finding.numbers,
            "explanation": " ".join(filter(None, (finding.remark, shown.get("text", "").strip()))),
            "shown_by": shown.get("command", ""),
            "recordings": {outcome: pages.get(outcome) for outcome in ("success", "failure")},
        }


@dataclass(frozen=True, slots=True)
class Ledger:
    """All rows, and how often fresh studies repeat them.

    Attributes:
        entries: Rows in the order of `ROWS`.
        repetition: How often fresh studies repeat the rows; None while attempts are missing.
    """

    entries: list[Entry]
    repetition: Repetition | None


def first_pass(evidence: Evidence) -> dict[str, Finding]:
    """Return the finding of every row, before Holm's correction."""
    return {claim.name: claim.judge(evidence) for claim in ROWS}


def judge_claims(evidence: Evidence, complete: bool = True, draws: int = DRAWS) -> Ledger:
    """Return every row of the ledger with its finding and typical attempts.

    Args:
        evidence: Attempts.
        complete: Whether every attempt of the ledger is there. Without it nothing has a verdict.
        draws: Number of fresh studies from which the probability of repeating a verdict is found.
    """
    findings = first_pass(evidence)
    judged = second_pass(findings)
    counting = tuple(
        claim.name for claim in CLAIMS if combine_verdicts(judged[claim.name]) not in ("calibrated", "reported")
    )
    repeated = repetition(evidence, first_pass, judged, counting, draws) if complete else None
    entries = [
        Entry(
            claim,
            findings[claim.name],
            judged[claim.name],
            choose_examples(claim, evidence),
            repeated.rows[claim.name] if repeated else None,
        )
        for claim in ROWS
    ]
    return Ledger(entries, repeated)


def ledger_documents(entries: Sequence[Entry]) -> list[dict[str, Any]]:
    """Return the ledger as JSON values."""
    explanations = read_toml(EXPLANATIONS)
    return [entry.as_dict(explanations.get(entry.claim.name, {})) for entry in entries]


def choose_examples(claim: Claim, evidence: Evidence) -> list[Example]:
    """Return a typical success and a typical failure, each from the first condition that has one."""
    found = {outcome: _typical(claim.shown, evidence, outcome) for outcome in ("success", "failure")}
    return [Example(row, outcome) for outcome, row in found.items() if row is not None]


def _typical(conditions: Sequence[Condition], evidence: Evidence, outcome: str) -> AttemptRow | None:
    """Return the attempt of median duration among those with the most frequent ending."""
    for condition in conditions:
        rows = [row for row in evidence.sample(condition).rows if row.success == (outcome == "success") and row.result]
        if rows:
            usual, _ = Counter(map(_ending, rows)).most_common(1)[0]
            alike = sorted((row for row in rows if _ending(row) == usual), key=_length)
            return alike[(len(alike) - 1) // 2]
    return None


def _ending(row: AttemptRow) -> tuple[int, str]:
    return row.grasped, str((row.result or {}).get("reason", ""))


def _length(row: AttemptRow) -> tuple[float, int]:
    return float((row.result or {}).get("sim_time", 0.0)), row.seed


def record_examples(
    examples: Iterable[Example], store: StudyStore, progress: Callable[[int, int], None] | None = None
) -> None:
    """Run the attempts again and write the pages that are missing, or that this program did not write.

    Raises:
        SimulationError: An attempt has another result than in the store.
    """
    from pilegrasp_ctrl.episode import run
    from pilegrasp_ctrl.viewer import write

    chosen = {example.page: example.row for example in examples}
    (store.folder / RECORDINGS).mkdir(exist_ok=True)
    for done, (page, row) in enumerate(chosen.items()):
        if progress:
            progress(done, len(chosen))
        if is_own(store.folder / page, page_origin(row)):
            continue
        episode = run(store.scenario(row.config_hash), seed=row.seed, record=True)
        if (episode.success, episode.grasped) != (row.success, row.grasped):
            raise SimulationError(
                f"seed {row.seed} of {row.config_hash} has another result now, so another version made "
                f"{store.path}; choose another folder"
            )
        if episode.recording is not None:
            write(episode.recording, store.folder / page)
            note_own(store.folder / page, page_origin(row))


def page_origin(row: AttemptRow) -> str:
    """Return a text that says which attempt, with which result, a page shows."""
    return json.dumps([row.config_hash, row.seed, row.result])
