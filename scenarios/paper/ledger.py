"""The ledger: every claim with its verdict, its numbers, and typical attempts, as one JSON document."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pilegrasp_ctrl.exceptions import SimulationError
from pilegrasp_ctrl.files import RECORDINGS, read_toml
from pilegrasp_ctrl.scenarios.paper import claims_mechanism, claims_objects, claims_piles
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.scenarios.paper.judgement import Claim, Finding
from pilegrasp_ctrl.study.attempt import AttemptRow
from pilegrasp_ctrl.study.condition import Condition
from pilegrasp_ctrl.study.store import StudyStore

CLAIMS = (*claims_objects.CLAIMS, *claims_piles.CLAIMS, *claims_mechanism.CLAIMS)
"""All claims of the paper, in the order of their names."""
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
    """A claim of the ledger.

    Attributes:
        claim: Claim of the paper.
        finding: Finding from the evidence.
        examples: Typical attempts.
    """

    claim: Claim
    finding: Finding
    examples: list[Example]

    def as_dict(self, explanation: Mapping[str, str]) -> dict[str, Any]:
        """Return plain JSON values; the explanation is given only for a claim that does not hold."""
        claim, finding = self.claim, self.finding
        shown = explanation if finding.verdict != "holds" else {}
        pages = {example.outcome: example.page for example in self.examples}
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
            "explanation": " ".join(filter(None, (finding.remark, shown.get("text", "").strip()))),
            "shown_by": shown.get("command", ""),
            "recordings": {outcome: pages.get(outcome) for outcome in ("success", "failure")},
        }


def judge_claims(evidence: Evidence) -> list[Entry]:
    """Return every claim with its finding and typical attempts."""
    return [Entry(claim, claim.judge(evidence), choose_examples(claim, evidence)) for claim in CLAIMS]


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
    """Run the attempts again and write the missing pages.

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
        if (store.folder / page).is_file():
            continue
        episode = run(store.scenario(row.config_hash), seed=row.seed, record=True)
        if (episode.success, episode.grasped) != (row.success, row.grasped):
            raise SimulationError(
                f"seed {row.seed} of {row.config_hash} has another result now, so another version made "
                f"{store.path}; choose another folder"
            )
        if episode.recording is not None:
            write(episode.recording, store.folder / page)
