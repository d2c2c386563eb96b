"""A claim of the paper, the statements that it consists of, and the verdict on each: holds, fails or not decided."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from pilegrasp_ctrl.scenarios.paper.evidence import Evidence, Sample
from pilegrasp_ctrl.statistics import p_greater
from pilegrasp_ctrl.study.condition import Condition

Verdict = Literal["holds", "fails", "not decided"]
"""Verdict on a statement or a claim."""

LEVEL = 0.05
"""Level of the one-sided test that compares two rates; chosen as usual."""
MIN_ATTEMPTS = 10
"""Smallest number of attempts that decides a statement; chosen."""
MAX_ERROR_SHARE = 0.1
"""Largest share of attempts with an error in a sample that decides a statement; chosen."""


@dataclass(frozen=True, slots=True)
class Judgement:
    """A statement and its verdict.

    Attributes:
        statement: Statement in words, with its numbers.
        verdict: Verdict on the statement.
    """

    statement: str
    verdict: Verdict


@dataclass(frozen=True, slots=True)
class Finding:
    """The result of judging a claim by the evidence.

    Attributes:
        parts: Statements that the claim consists of.
        samples: Attempts behind the finding, by the name of their condition.
        numbers: Other numbers behind the finding, as JSON values.
        remark: Remark for the reader beside the verdict.
    """

    parts: tuple[Judgement, ...]
    samples: dict[str, Sample]
    numbers: dict[str, Any] = field(default_factory=dict)
    remark: str = ""

    @property
    def verdict(self) -> Verdict:
        """The verdict of all parts together."""
        return combine_verdicts(self.parts)


@dataclass(frozen=True, slots=True)
class Claim:
    """One claim of the paper, and the condition by which this project judges itself.

    Attributes:
        name: Name, C1 to C16.
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


def combine_verdicts(parts: Iterable[Judgement]) -> Verdict:
    """Return the verdict of a claim: "fails" if a part fails, "holds" if all parts hold, otherwise "not decided"."""
    verdicts = [part.verdict for part in parts]
    if "fails" in verdicts:
        return "fails"
    return "holds" if verdicts and all(verdict == "holds" for verdict in verdicts) else "not decided"


def judge(statement: str, holds: bool, *samples: Sample, enough: int = MIN_ATTEMPTS) -> Judgement:
    """Judge a statement by whether it holds, if its samples are large enough."""
    reason = undecided_reason(*samples, enough=enough)
    return Judgement(statement + reason, "not decided" if reason else "holds" if holds else "fails")


def undecided_reason(*samples: Sample, enough: int = MIN_ATTEMPTS) -> str:
    """Return the reason why the samples decide nothing, to append to a statement; "" if they decide."""
    fewest = min((sample.n for sample in samples), default=0)
    if fewest < enough:
        return f"; {fewest or 'no'} attempts are too few" if fewest != 1 else "; 1 attempt is too few"
    if any(sample.errors > MAX_ERROR_SHARE * sample.n for sample in samples):
        worst = max(samples, key=lambda sample: sample.errors / sample.n)
        return f"; {worst.errors} of {worst.n} attempts raised an error"
    return ""


def judge_at_least(name: str, sample: Sample, least: float) -> Judgement:
    """Judge whether the rate reaches a value."""
    return judge(
        f"{name}: {format_rate(sample)}, at least {format_percent(least)} asked", sample.rate >= least - 1e-12, sample
    )


def judge_below(name: str, sample: Sample, bound: float) -> Judgement:
    """Judge whether the rate stays below a value."""
    return judge(f"{name}: {format_rate(sample)}, below {format_percent(bound)} asked", sample.rate < bound, sample)


def judge_greater(first_name: str, first: Sample, second_name: str, second: Sample) -> Judgement:
    """Judge whether the first rate is higher; without a significant difference the statement is not decided."""
    text = f"{first_name} {format_rate(first)} above {second_name} {format_rate(second)}"
    if reason := undecided_reason(first, second):
        return Judgement(text + reason, "not decided")
    p = _p_higher(first, second)
    if p < LEVEL:
        return Judgement(f"{text}: p = {p:.2g}", "holds")
    reverse = _p_higher(second, first)
    return Judgement(f"{text}: p = {p:.2g}", "fails" if reverse < LEVEL else "not decided")


def judge_not_less(first_name: str, first: Sample, second_name: str, second: Sample) -> Judgement:
    """Judge whether the first rate reaches the second; a lower rate without significance is not decided."""
    text = f"{first_name} {format_rate(first)} at least {second_name} {format_rate(second)}"
    if reason := undecided_reason(first, second):
        return Judgement(text + reason, "not decided")
    if first.rate >= second.rate:
        return Judgement(text, "holds")
    p = _p_higher(second, first)
    return Judgement(f"{text}: it is less, p = {p:.2g}", "fails" if p < LEVEL else "not decided")


def judge_not_above(first_name: str, first: Sample, second_name: str, second: Sample) -> Judgement:
    """Judge whether the first rate stays at or below the second; only a significantly higher rate fails."""
    text = f"{first_name} {format_rate(first)} not above {second_name} {format_rate(second)}"
    if reason := undecided_reason(first, second):
        return Judgement(text + reason, "not decided")
    p = _p_higher(first, second)
    return Judgement(f"{text}: p = {p:.2g} for above", "fails" if p < LEVEL else "holds")


def _p_higher(first: Sample, second: Sample) -> float:
    """Return the one-sided p-value of the hypothesis that the first rate is higher."""
    return p_greater(first.successes, first.n, second.successes, second.n)


def format_rate(sample: Sample) -> str:
    """Return a rate with its interval as text in percent."""
    if not sample.n:
        return "(not run)"
    low, high = sample.interval
    return f"{format_percent(sample.rate)} of {sample.n} ({100 * low:.0f} to {format_percent(high)})"


def format_percent(share: float) -> str:
    """Return a share as text in percent."""
    return f"{100.0 * share:.0f} %"
