"""Ask the program thousands of questions and print a table: kind, inputs tried, answered well, not.

Usage: python tests/fuzz/table.py [--minutes M] [--inputs N] [--seed S] [--keep FOLDER] [KIND...]

A kind ends after N inputs or M minutes, whichever comes later; servers end when all were asked. Inputs that are not
answered well are kept in FOLDER; the exit status is then 1.
"""

from __future__ import annotations

import argparse
import hashlib
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parents[1] / "helpers"), str(Path(__file__).parents[2])]

from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import seed as seeded
from hypothesis.strategies import SearchStrategy

from answering import Responder
from kinds import KINDS, judge
from pilegrasp_ctrl.statistics import markdown_table
from question import Question
from servers import CASES, fault_of_case
from signals import fault_of_trial, trials

BATCH = 50
"""Inputs that hypothesis draws at a time [-] (chosen)."""


@dataclass
class Count:
    """Inputs of one kind: how many were tried, how they ended, and what was wrong."""

    kind: str
    tried: int = 0
    accepted: int = 0
    faults: Counter[str] = field(default_factory=Counter)
    seconds: float = 0.0

    @property
    def bad(self) -> int:
        """Number of inputs that were not answered well."""
        return sum(self.faults.values())


def draw(kind: str, seed: int, batch: int = BATCH) -> Iterator[Question]:
    """Yield inputs of a kind without end; the same seed and batch give the same ones."""
    while True:
        yield from _batch(KINDS[kind], seed, batch)
        seed += 1


def _batch(strategy: SearchStrategy[Question], seed: int, size: int) -> list[Question]:
    found: list[Question] = []

    def collect(question: Question) -> None:
        found.append(question)

    options = settings(
        max_examples=size,
        phases=[Phase.generate],
        database=None,
        deadline=None,
        suppress_health_check=list(HealthCheck),
    )
    seeded(seed)(options(given(question=strategy)(collect)))()
    return found


def fuzz(kind: str, inputs: int, minutes: float, seed: int, keep: Path) -> Count:
    """Try inputs of a kind, and keep those that are not answered well."""
    count, begin = Count(kind), time.monotonic()
    with Responder() as responder:
        for tried in OTHERS[kind](responder, seed) if kind in OTHERS else _ask(responder, kind, seed):
            count.tried += 1
            count.accepted += tried.accepted
            if tried.fault is not None:
                count.faults[tried.fault[:200]] += 1
                _keep(keep, kind, tried)
            count.seconds = time.monotonic() - begin
            if count.tried >= inputs and count.seconds >= 60.0 * minutes:
                break
    return count


@dataclass(frozen=True, slots=True)
class Tried:
    """An input that was tried: its text, whether it was accepted, and what was wrong with the answer."""

    text: str
    accepted: bool
    fault: str | None


def _ask(responder: Responder, kind: str, seed: int) -> Iterator[Tried]:
    for question in draw(kind, seed):
        answer = responder.ask(question)
        yield Tried(question.to_json(), answer.status == 0, judge(question, answer))


def _signals(responder: Responder, seed: int) -> Iterator[Tried]:
    for trial in trials(seed):
        yield Tried(repr(trial), False, fault_of_trial(trial))


def _servers(responder: Responder, seed: int) -> Iterator[Tried]:
    for case in CASES:
        yield Tried(case, False, fault_of_case(responder, case))


OTHERS: dict[str, Callable[[Responder, int], Iterator[Tried]]] = {"server": _servers, "signal": _signals}
"""Kinds that are no files and no command lines alone."""

FEWER = {"signal": 60, "corner": 100}
"""Least number of inputs of kinds whose inputs take seconds."""


def _keep(folder: Path, kind: str, tried: Tried) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    name = f"{kind.replace(' ', '-')}-{hashlib.sha256(tried.text.encode()).hexdigest()[:12]}"
    (folder / f"{name}.json").write_text(tried.text)
    (folder / f"{name}.txt").write_text(f"{tried.fault}\n")


def main() -> int:
    """Fuzz the kinds and print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--minutes", type=float, default=0.0, help="least time for each kind [min]")
    parser.add_argument("--inputs", type=int, default=250, help="least number of inputs for each kind")
    parser.add_argument("--seed", type=int, default=0, help="seed of the inputs")
    parser.add_argument("--keep", type=Path, default=Path("build/fuzz"), help="folder for inputs that fail")
    parser.add_argument("kinds", nargs="*", metavar="KIND", help="kinds of inputs; all by default")
    chosen = parser.parse_args()
    known = (*KINDS, *OTHERS)
    for kind in chosen.kinds:
        if kind not in known:
            parser.error(f"{kind!r} is not a kind; choose from {', '.join(map(repr, known))}")
    counts = []
    for kind in chosen.kinds or known:
        inputs = min(chosen.inputs, FEWER.get(kind, chosen.inputs))
        counts.append(fuzz(kind, inputs, chosen.minutes, chosen.seed, chosen.keep))
        print(f"{kind}: {counts[-1].tried} tried, {counts[-1].bad} not well", file=sys.stderr, flush=True)
        for fault, number in counts[-1].faults.most_common():
            print(f"  {number} x {fault}", file=sys.stderr, flush=True)
    rows = [
        (count.kind, count.tried, count.accepted, count.tried - count.bad, count.bad, f"{count.seconds / 60.0:.1f}")
        for count in counts
    ]
    print(markdown_table(("kind", "inputs tried", "accepted", "answered well", "not", "minutes"), rows))
    return int(any(count.bad for count in counts))


if __name__ == "__main__":
    sys.exit(main())
