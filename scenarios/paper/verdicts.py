"""The second pass over the ledger: Holm's correction over all its tests, and the verdict of every row."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from pilegrasp_ctrl.scenarios.paper.comparisons import holm
from pilegrasp_ctrl.scenarios.paper.judgement import LEVEL, Finding, Judgement, Outcome, Significance, Verdict


@dataclass(frozen=True, slots=True)
class Judged:
    """A statement after the second pass.

    Attributes:
        statement: Statement in words.
        outcome: What the attempts say.
        verdict: The outcome, or "calibrated" or "reported" where it counts for nothing.
        test: P-values after Holm's correction, or None.
    """

    statement: str
    outcome: Outcome
    verdict: Verdict
    test: Significance | None

    @property
    def _p_text(self) -> str:
        if self.test is None:
            return ""
        if self.test.p is None:
            return f": it is less, p = {self.test.reverse:.2g}"
        return f": p = {self.test.p:.2g}"

    def as_dict(self, complete: bool) -> dict[str, Any]:
        """Return plain JSON values; verdict and outcome are None while attempts are missing."""
        return {
            "statement": self.statement + self._p_text if complete else self.statement,
            "verdict": self.verdict if complete else None,
            "outcome": self.outcome if complete and self.verdict != "reported" else None,
            "p": self.test.p if self.test and complete else None,
        }


def second_pass(findings: Mapping[str, Finding]) -> dict[str, tuple[Judged, ...]]:
    """Return the statements of every row, judged with all tests of the ledger together.

    Statements and their reverses are two families of tests, each corrected for its number. Tests of rows that nothing
    is asked of do not count.
    """
    tests = {
        (name, place): part.test
        for name, finding in findings.items()
        for place, part in enumerate(finding.parts)
        if part.test is not None and not part.reported
    }
    asked = {key: test.p for key, test in tests.items() if test.p is not None}
    forward = dict(zip(asked, holm(list(asked.values())), strict=True))
    backward = dict(zip(tests, holm([test.reverse for test in tests.values()]), strict=True))
    return {
        name: tuple(
            _judged(part, forward.get((name, place)), backward.get((name, place)))
            for place, part in enumerate(finding.parts)
        )
        for name, finding in findings.items()
    }


def _judged(part: Judgement, p: float | None, reverse: float | None) -> Judged:
    outcome, test = part.outcome, part.test
    if test is not None:
        if not part.reported and reverse is not None:
            test = replace(test, p=p, reverse=reverse)
        outcome = outcome or outcome_of(test)
    verdict: Verdict = outcome or "undecided"
    if part.calibrated or part.reported:
        verdict = "calibrated" if part.calibrated else "reported"
    return Judged(part.statement, outcome or "undecided", verdict, test)


def outcome_of(test: Significance) -> Outcome:
    """Return what a test says at `LEVEL`."""
    if test.p is not None and test.p < LEVEL:
        return "holds"
    return "fails" if test.reverse < LEVEL else "undecided"


def combine_verdicts(parts: Sequence[Judged]) -> Verdict:
    """Return the verdict of a row: "fails" if a statement that counts fails, "holds" if all hold, else "undecided".

    A row without a statement that counts is "calibrated" if it has a calibrated one, else "reported".
    """
    counting = [part.verdict for part in parts if part.verdict not in ("calibrated", "reported")]
    if not counting:
        fitted = any(part.verdict == "calibrated" for part in parts)
        return "calibrated" if fitted else "reported" if parts else "undecided"
    if "fails" in counting:
        return "fails"
    return "holds" if all(verdict == "holds" for verdict in counting) else "undecided"


def combine_outcomes(parts: Sequence[Judged]) -> Outcome:
    """Return what the attempts say about all statements of a row together, calibrated ones included."""
    outcomes = [part.outcome for part in parts if part.verdict != "reported"]
    if "fails" in outcomes:
        return "fails"
    return "holds" if outcomes and all(outcome == "holds" for outcome in outcomes) else "undecided"


def shown_outcome(parts: Sequence[Judged]) -> Outcome:
    """Return what a row says: its verdict, or the outcome of its statements if the row counts for nothing."""
    verdict = combine_verdicts(parts)
    if verdict == "calibrated" or verdict == "reported":
        return combine_outcomes(parts)
    return verdict
