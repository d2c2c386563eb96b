"""The head of a page: verdict, facts, primitives and events. Any key of the meta may be missing or of a wrong type."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from pilegrasp_ctrl.analysis.reading import lookup, number, plain, text
from pilegrasp_ctrl.recording import Recording


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
class Event:
    """A mark on the timeline: `kind` is "end", "failure", "separation" or "saturation"."""

    time: float
    kind: str
    words: str


@dataclass(frozen=True, slots=True)
class Summary:
    """The facts of the page's head; `facts` are (label, text) pairs in reading order."""

    scenario: str
    seed: str
    success: bool | None
    verdict: str
    reason: str
    grasp_force: float | None
    primitives: tuple[PrimitiveRow, ...]
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


def separated(meta: Mapping[str, Any]) -> tuple[str, float] | None:
    """Return the name of the object that separated from the pile and the time since then [s], if it is known."""
    name, time = (lookup(meta, f"motion.separated.{key}") for key in ("object", "time"))
    moment = number(time)
    return (name, moment) if isinstance(name, str) and moment is not None else None


def events(recording: Recording, rows: tuple[PrimitiveRow, ...]) -> list[Event]:
    """Return the events of a recording, in order of time."""
    found = []
    for row in rows:
        cause = plain(row.trigger) or ("failed" if row.failed else "ended")
        found.append(Event(row.end, "failure" if row.failed else "end", f"{row.name}: {cause}"))
    if apart := separated(recording.meta):
        found.append(Event(apart[1], "separation", f"{text(apart[0], 40)} separates from the pile"))
    saturated = recording.signals.get("sensor_saturated")
    if saturated is not None and saturated.ndim == 1 and (saturated > 0.5).any():
        moment = float(recording.signal_time[int(np.argmax(saturated > 0.5))])
        found.append(Event(moment, "saturation", "the wrist sensor is at its range"))
    first, last = float(recording.frame_time[0]), float(recording.frame_time[-1])
    return sorted((e for e in found if first - 0.1 <= e.time <= last + 0.1), key=lambda event: event.time)


def _verdict(success: bool | None, grasped: float | None) -> str:
    word = {True: "Success", False: "Failed", None: "Recorded"}[success]
    if not grasped or grasped < 1:
        return word
    return f"{word}: {int(grasped)} object{'s' if grasped > 1 else ''} held"


def _ending(success: bool | None, reason: str, rows: tuple[PrimitiveRow, ...]) -> str:
    """Return why and when the attempt ended; without a recorded reason, the last primitive's trigger is the reason."""
    if not rows:
        return reason
    last = rows[-1]
    time = f"{last.end:.1f}\N{NO-BREAK SPACE}s"
    if success and not reason:
        return f"after {time}"
    cause = reason or f"{last.name}: {plain(last.trigger) or 'ended'}"
    return f"{cause}, at {time}"


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
    straight = lookup(config, "program") == "line"
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
    return Summary(
        scenario=text(meta.get("scenario"), 80) or "recording",
        seed=text(meta.get("seed"), 30),
        success=success,
        verdict=_verdict(success, number(meta.get("grasped"))),
        reason=_ending(success, text(meta.get("reason")), rows),
        grasp_force=None if straight else grasp_force,
        primitives=rows,
        facts=tuple(facts),
        versions=tuple(
            (text(name, 40), text(version, 40))
            for name, version in (versions.items() if isinstance(versions, Mapping) else ())
        ),
    )
