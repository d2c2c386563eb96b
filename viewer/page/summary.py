"""The head of a page: verdict, facts, primitives, attempts. Any key of the meta may be missing or of a wrong type."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pilegrasp_ctrl.analysis.carried import ENDINGS
from pilegrasp_ctrl.analysis.reading import lookup, number, plain, text
from pilegrasp_ctrl.program_traits import traits_of


@dataclass(frozen=True, slots=True)
class PrimitiveRow:
    """A row of the page's table: one primitive as it ran.

    Attributes:
        name: Name of the primitive.
        failed: Whether the primitive failed.
        trigger: Event that ended the primitive; may be empty.
        start: Time of the start [s].
        end: Time of the end [s].
        travel: Distance that the tool moved [m], if known.
        peak_force: Largest force [N], if known.
    """

    name: str
    failed: bool
    trigger: str
    start: float
    end: float
    travel: float | None
    peak_force: float | None


@dataclass(frozen=True, slots=True)
class AttemptRow:
    """One attempt of an order: its `number` from 1 on, what came of it, and its `reason`, empty after a delivery."""

    number: int
    goal: str
    held: int
    delivered: int
    reason: str
    start: float
    end: float

    @property
    def words(self) -> str:
        """Return what came of the attempt in a few words."""
        return f"{self.delivered} delivered" if self.delivered else self.reason or "nothing delivered"


@dataclass(frozen=True, slots=True)
class Summary:
    """The facts of the page's head; `facts` are (label, text) pairs in reading order, `attempts` those of an order."""

    scenario: str
    seed: str
    success: bool | None
    verdict: str
    reason: str
    cause: str
    grasp_force: float | None
    primitives: tuple[PrimitiveRow, ...]
    attempts: tuple[AttemptRow, ...]
    facts: tuple[tuple[str, str], ...]
    versions: tuple[tuple[str, str], ...]


def primitive_rows(outcomes: Any) -> tuple[PrimitiveRow, ...]:
    """Return the primitives that can be drawn: those with a name, a start and an end."""
    rows = []
    for row in outcomes if isinstance(outcomes, list) else []:
        start, end = number(lookup(row, "start")), number(lookup(row, "end"))
        name = text(lookup(row, "name"), 40)
        if name and start is not None and end is not None and end >= start:
            rows.append(
                PrimitiveRow(
                    name=name,
                    failed=lookup(row, "status") == "failed",
                    trigger=text(lookup(row, "trigger"), 120),
                    start=start,
                    end=end,
                    travel=number(lookup(row, "travel")),
                    peak_force=number(lookup(row, "peak_force")),
                )
            )
    return tuple(rows)


def attempt_rows(attempts: Any) -> tuple[AttemptRow, ...]:
    """Return the attempts of an order that have a start and an end, in the order of their starts."""
    spans = []
    for row in attempts if isinstance(attempts, list) else []:
        start, end = number(lookup(row, "start")), number(lookup(row, "end"))
        if start is not None and end is not None and end >= start:
            spans.append((start, end, row))
    return tuple(
        AttemptRow(
            number=index,
            goal=plain(text(lookup(row, "goal"), 40)),
            held=int(number(lookup(row, "held")) or 0),
            delivered=int(number(lookup(row, "delivered")) or 0),
            reason=text(lookup(row, "reason"), 120),
            start=start,
            end=end,
        )
        for index, (start, end, row) in enumerate(sorted(spans, key=lambda span: span[0]), start=1)
    )


_COUNT = re.compile(r"\d+ of \d+ delivered after \d+ attempts?")
"""Reason of an order that has used up its attempts."""


def _counted(count: float, name: str) -> str:
    return f"{int(count)} {name}{'' if int(count) == 1 else 's'}"


def _verdict(
    success: bool | None, grasped: float | None, attempts: tuple[AttemptRow, ...], wanted: float | None
) -> str:
    word = {True: "Success", False: "Failed", None: "Recorded"}[success]
    if attempts:
        delivered = sum(row.delivered for row in attempts)
        share = f"{delivered} of {int(wanted)}" if wanted and delivered < wanted else f"{delivered}"
        surplus = sum(row.held for row in attempts if "dropped back" in row.reason)
        more = f", {surplus} dropped back" if surplus else ""
        return f"{word}: {share} delivered in {_counted(len(attempts), 'attempt')}{more}"
    if not grasped or grasped < 1:
        return word
    return f"{word}: {_counted(grasped, 'object')} held"


def _ending(success: bool | None, reason: str, rows: tuple[PrimitiveRow, ...]) -> str:
    """Return why and when the attempt ended; without a recorded reason, the last primitive's trigger is the reason.

    The verdict of an order counts deliveries and attempts, so a reason that only counts them again is left out.
    """
    if not rows:
        return reason
    last = rows[-1]
    time = f"{last.end:.1f}\N{NO-BREAK SPACE}s"
    if (success and not reason) or _COUNT.fullmatch(reason):
        return f"after {time}"
    cause = reason or f"{last.name}: {plain(last.trigger) or 'ended'}"
    return f"{cause}, at {time}"


def tally(counts: Any, success: bool | None) -> str:
    """Return how many objects came into the hand and what became of them, as "2 taken: 1 kept, 1 lost".

    Args:
        counts: Counts as `analysis.carried.count_carried` returns them; "" if they are unknown.
        success: Whether the attempt succeeded; a failure that took nothing needs no words, because its reason says so.
    """
    taken = number(lookup(counts, "taken"))
    if taken is None:
        return ""
    if taken < 1:
        return "" if success is False else "nothing was in the hand"
    found = ((ending, int(number(lookup(counts, ending)) or 0)) for ending in ENDINGS)
    return f"{int(taken)} taken: {', '.join(f'{count} {ending}' for ending, count in found if count)}"


_FACTS = (
    ("hand", "hand", ""),
    ("object", "pile.object", ""),
    ("count", "pile.count", ""),
    ("support", "support.kind", ""),
    ("tilt", "support.tilt_deg", "°"),
    ("alpha", "strategy.alpha_deg", "°"),
    ("beta", "strategy.beta_deg", "°"),
    ("theta", "strategy.theta_deg", "°"),
    ("speed", "strategy.speed", " m/s"),
    ("F_grasp", "strategy.grasp_force", " N"),
    ("line speed", "line.speed", " m/s"),
    ("controller", "controller.kind", ""),
    ("solver", "controller.solver", ""),
)


def summarize(meta: Mapping[str, Any]) -> Summary:
    """Return the head of a page; a missing key leaves a gap and raises nothing."""
    config = meta.get("config")
    success = meta.get("success")
    success = success if isinstance(success, bool) else None
    facts = []
    straight = not traits_of(str(lookup(config, "program"))).touches
    idle = {"strategy.": straight, "line.": not straight, "pile.object": lookup(config, "pile.count") == 0}
    for label, key, unit in _FACTS:
        if any(key.startswith(start) for start, unused in idle.items() if unused):
            continue
        value = lookup(config, key)
        value = meta.get(key) if value is None else value
        if isinstance(value, str | int | float) and value != "" and not (unit == "°" and value == 0):
            facts.append((label, text(value, 60) + unit))
    versions = meta.get("versions")
    grasp_force = number(meta.get("grasp_force"))
    if grasp_force is None:
        grasp_force = number(lookup(config, "strategy.grasp_force"))
    rows = primitive_rows(meta.get("outcomes"))
    attempts = attempt_rows(meta.get("attempts"))
    return Summary(
        scenario=text(meta.get("scenario"), 80) or "recording",
        seed=text(meta.get("seed"), 30),
        success=success,
        verdict=_verdict(success, number(meta.get("grasped")), attempts, number(lookup(config, "order.count"))),
        reason=_ending(success, text(meta.get("reason")), rows),
        cause=text(meta.get("reason"), 120),
        grasp_force=None if straight else grasp_force,
        primitives=rows,
        attempts=attempts,
        facts=tuple(facts),
        versions=tuple(
            (text(name, 40), text(version, 40))
            for name, version in (versions.items() if isinstance(versions, Mapping) else ())
        ),
    )
