"""A claim of the paper, the statements that it consists of, and the first pass of judging: outcomes and p-values."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from pilegrasp_ctrl.scenarios.paper.comparisons import p_higher, p_mcnemar
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence, Sample, pairs, wilson
from pilegrasp_ctrl.study.condition import Condition

Outcome = Literal["holds", "fails", "undecided"]
"""What the attempts say about a statement."""
Verdict = Literal["holds", "fails", "undecided", "calibrated", "reported"]
"""Verdict on a statement or a row. "calibrated": a number of the model was chosen by this very statement, so it shows
what the model was fitted to. "reported": nothing is asked."""

LEVEL = 0.05
"""Level of the one-sided tests, after Holm's correction over the tests of the ledger; chosen as usual."""
MIN_ATTEMPTS = 10
"""Smallest number of attempts that decides a statement; chosen."""
MAX_ERROR_SHARE = 0.1
"""Largest share of attempts with an error in a sample that decides a statement; chosen."""


@dataclass(frozen=True, slots=True)
class Significance:
    """The p-values of "A > B" and of the reverse.

    Attributes:
        p: One-sided p-value; None where the statement asks for "at least" and the estimate reaches it.
        reverse: One-sided p-value of the reverse.
    """

    p: float | None
    reverse: float


@dataclass(frozen=True, slots=True)
class Judgement:
    """A statement, and what the attempts say about it.

    Attributes:
        statement: Statement in words, with its numbers.
        outcome: What the attempts say; None if the test decides, which needs all tests of the ledger.
        test: Significance of the statement, or None.
        calibrated: Whether a number of the model was chosen by this statement.
        reported: Whether nothing is asked.
    """

    statement: str
    outcome: Outcome | None = None
    test: Significance | None = None
    calibrated: bool = False
    reported: bool = False


@dataclass(frozen=True, slots=True)
class Finding:
    """The first pass over a row of the ledger.

    Attributes:
        parts: Statements that the row consists of.
        samples: Attempts behind the finding, by the name of their condition.
        numbers: Other numbers behind the finding, as JSON values.
        remark: Remark for the reader beside the verdict.
    """

    parts: tuple[Judgement, ...]
    samples: dict[str, Sample]
    numbers: dict[str, Any] = field(default_factory=dict)
    remark: str = ""


@dataclass(frozen=True, slots=True)
class Claim:
    """One row of the ledger: a claim of the paper or a null model, and the condition by which this project judges it.

    Attributes:
        name: Name, C1 to C16 or N1 to N4.
        place: Section or figure of the claim in the paper.
        text: Claim in one sentence.
        paper: Numbers that the paper reports.
        predicate: Condition by which this project judges itself.
        judge: Function from evidence to finding.
        shown: Conditions of the typical success and failure on the page, the most instructive first.
    """

    name: str
    place: str
    text: str
    paper: str
    predicate: str
    judge: Callable[[Evidence], Finding]
    shown: Sequence[Condition] = ()


def judge(statement: str, holds: bool, *samples: Sample, enough: int = MIN_ATTEMPTS) -> Judgement:
    """Judge a statement by whether it holds, if its samples are large enough."""
    reason = undecided_reason(*samples, enough=enough)
    return Judgement(statement + reason, "undecided" if reason else "holds" if holds else "fails")


def undecided_reason(*samples: Sample, enough: int = MIN_ATTEMPTS) -> str:
    """Return the reason why the samples decide nothing, to append to a statement; "" if they decide."""
    fewest = min((sample.n for sample in samples), default=0)
    if fewest < enough:
        return f"; {fewest or 'no'} attempts are too few" if fewest != 1 else "; 1 attempt is too few"
    for sample in samples:
        if sample.errors > MAX_ERROR_SHARE * sample.n:
            return f"; {sample.errors} of {sample.n} attempts raised an error"
    return ""


def judge_at_least(name: str, sample: Sample, least: float) -> Judgement:
    """Judge whether the rate reaches a value."""
    text = f"{name}: {format_rate(sample)}, at least {format_percent(least)} asked"
    return judge(text, sample.rate >= least - 1e-12, sample)


def judge_below(name: str, sample: Sample, bound: float) -> Judgement:
    """Judge whether the rate stays below a value."""
    return judge(f"{name}: {format_rate(sample)}, below {format_percent(bound)} asked", sample.rate < bound, sample)


def judge_greater(first_name: str, first: Sample, second_name: str, second: Sample, paired: bool = False) -> Judgement:
    """Judge whether the first rate is higher, by Fisher's test, or McNemar's where the piles are the same."""
    text = f"{first_name} {format_rate(first)} above {second_name} {format_rate(second)}"
    if reason := undecided_reason(first, second):
        return Judgement(text + reason, "undecided")
    if paired:
        _, only, other, _ = pairs(first, second)
        test = Significance(p_mcnemar(only, other), p_mcnemar(other, only))
        text += f", {only} pairs to {other}"
    else:
        test = Significance(_p_higher(first, second), _p_higher(second, first))
    return Judgement(text, None, test)


def judge_not_less(first_name: str, first: Sample, second_name: str, second: Sample) -> Judgement:
    """Judge whether the first rate reaches the second; a lower rate fails only if the test of the reverse finds it."""
    text = f"{first_name} {format_rate(first)} at least {second_name} {format_rate(second)}"
    if reason := undecided_reason(first, second):
        return Judgement(text + reason, "undecided")
    if first.rate >= second.rate:
        return Judgement(text, "holds")
    return Judgement(text, None, Significance(None, _p_higher(second, first)))


def _p_higher(first: Sample, second: Sample) -> float:
    return p_higher(first.successes, first.n, second.successes, second.n)


def format_rate(sample: Sample) -> str:
    """Return a rate with its interval as text in percent."""
    return format_share(sample.successes, sample.n)


def format_share(count: int, n: int) -> str:
    """Return a share with its interval as text in percent."""
    if not n:
        return "(not run)"
    low, high = wilson(count, n)
    return f"{format_percent(count / n)} of {n} ({100 * low:.0f} to {format_percent(high)})"


def format_percent(share: float) -> str:
    """Return a share as text in percent."""
    return f"{100.0 * share:.0f} %"
