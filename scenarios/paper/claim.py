"""One claim of the paper: what it says, and how this project judges itself by it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.scenarios.paper.judgement import Judgement, Verdict, all_of
from pilegrasp_ctrl.scenarios.paper.sample import Sample
from pilegrasp_ctrl.study.condition import Condition


@dataclass(frozen=True, slots=True)
class Finding:
    """What the evidence says about a claim.

    Attributes:
        parts: the statements that the claim consists of.
        samples: the attempts it rests on, by the name of their condition.
        numbers: other numbers that it rests on, as JSON values.
        remark: what a reader should know beside the verdict.
    """

    parts: tuple[Judgement, ...]
    samples: dict[str, Sample]
    numbers: dict[str, Any] = field(default_factory=dict)
    remark: str = ""

    @property
    def verdict(self) -> Verdict:
        """The verdict of all parts together."""
        return all_of(self.parts)


@dataclass(frozen=True, slots=True)
class Claim:
    """A claim.

    Attributes:
        name: C1 to C16.
        place: where the paper makes it.
        text: what it says.
        paper: what the paper reports.
        predicate: by which this project judges itself.
        judge: from evidence to finding.
        shown: the conditions of which a success and a failure are shown, the most telling first.
    """

    name: str
    place: str
    text: str
    paper: str
    predicate: str
    judge: Callable[[Evidence], Finding]
    shown: Sequence[Condition] = ()


def named(evidence: Evidence, conditions: dict[str, Condition]) -> dict[str, Sample]:
    """Return the attempts at each condition."""
    return {name: evidence.of(condition) for name, condition in conditions.items()}
