"""Statements about rates, each with a verdict: it holds, it fails, or it is not decided."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from pilegrasp_ctrl.scenarios.paper.sample import Sample
from pilegrasp_ctrl.statistics import p_greater

Verdict = Literal["holds", "fails", "not decided"]

LEVEL = 0.05
"""Of the one-sided test with which two rates are compared."""
ENOUGH = 10
"""Fewer attempts than this decide nothing."""
MOST_ERRORS = 0.1
"""Where a larger share of attempts raised an error, the rest decides nothing."""


@dataclass(frozen=True, slots=True)
class Judgement:
    """A statement and what became of it.

    Attributes:
        statement: in words, with the numbers that it rests on.
        verdict: of the statement.
    """

    statement: str
    verdict: Verdict


def all_of(parts: Iterable[Judgement]) -> Verdict:
    """Return the verdict of a claim: one part that fails fails it, one that is not decided leaves it open."""
    verdicts = [part.verdict for part in parts]
    if "fails" in verdicts:
        return "fails"
    return "holds" if verdicts and all(verdict == "holds" for verdict in verdicts) else "not decided"


def stated(statement: str, holds: bool, *samples: Sample, enough: int = ENOUGH) -> Judgement:
    """Judge by a yes or no, where the samples it rests on allow it."""
    reason = why_open(*samples, enough=enough)
    return Judgement(statement + reason, "not decided" if reason else "holds" if holds else "fails")


def why_open(*samples: Sample, enough: int = ENOUGH) -> str:
    """Return why the samples decide nothing, as an appendix to a statement, or ""."""
    fewest = min((sample.n for sample in samples), default=0)
    if fewest < enough:
        return f"; {fewest or 'no'} attempts are too few" if fewest != 1 else "; 1 attempt is too few"
    if any(sample.errors > MOST_ERRORS * sample.n for sample in samples):
        worst = max(samples, key=lambda sample: sample.errors / sample.n)
        return f"; {worst.errors} of {worst.n} attempts raised an error"
    return ""


def at_least(name: str, sample: Sample, least: float) -> Judgement:
    """Judge whether the rate reaches a value."""
    return stated(f"{name}: {rate_text(sample)}, at least {percent(least)} asked", sample.rate >= least - 1e-12, sample)


def below(name: str, sample: Sample, bound: float) -> Judgement:
    """Judge whether the rate stays below a value."""
    return stated(f"{name}: {rate_text(sample)}, below {percent(bound)} asked", sample.rate < bound, sample)


def greater(first_name: str, first: Sample, second_name: str, second: Sample) -> Judgement:
    """Judge whether the first rate is higher: it is where the test says so, it is not where the reverse is so."""
    text = f"{first_name} {rate_text(first)} above {second_name} {rate_text(second)}"
    if reason := why_open(first, second):
        return Judgement(text + reason, "not decided")
    p = _p_greater(first, second)
    if p < LEVEL:
        return Judgement(f"{text}: p = {p:.2g}", "holds")
    reverse = _p_greater(second, first)
    return Judgement(f"{text}: p = {p:.2g}", "fails" if reverse < LEVEL else "not decided")


def not_less(first_name: str, first: Sample, second_name: str, second: Sample) -> Judgement:
    """Judge whether the first rate reaches the second; a lag that may be chance leaves it open."""
    text = f"{first_name} {rate_text(first)} at least {second_name} {rate_text(second)}"
    if reason := why_open(first, second):
        return Judgement(text + reason, "not decided")
    if first.rate >= second.rate:
        return Judgement(text, "holds")
    p = _p_greater(second, first)
    return Judgement(f"{text}: it is less, p = {p:.2g}", "fails" if p < LEVEL else "not decided")


def never_above(first_name: str, first: Sample, second_name: str, second: Sample) -> Judgement:
    """Judge whether the first rate stays at or below the second, as far as the test can tell."""
    text = f"{first_name} {rate_text(first)} not above {second_name} {rate_text(second)}"
    if reason := why_open(first, second):
        return Judgement(text + reason, "not decided")
    p = _p_greater(first, second)
    return Judgement(f"{text}: p = {p:.2g} for above", "fails" if p < LEVEL else "holds")


def _p_greater(first: Sample, second: Sample) -> float:
    """Return the one-sided p-value of the hypothesis that the first rate is higher."""
    return p_greater(first.successes, first.n, second.successes, second.n)


def rate_text(sample: Sample) -> str:
    """Return a rate with its interval, as people read it."""
    if not sample.n:
        return "(not run)"
    low, high = sample.interval
    return f"{percent(sample.rate)} of {sample.n} ({100 * low:.0f} to {percent(high)})"


def percent(share: float) -> str:
    """Return a share as people read it."""
    return f"{100.0 * share:.0f} %"
