"""What the hand carried: which objects hung in it, from when to when, and which of them it lost."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..recording import Recording
from ..types import Array
from ..vectors import norm
from .kept_objects import HELD_DISTANCE
from .reading import lookup, number, signal_at, text

RISE = 0.03
"""Height by which object and hand must both have risen since the hand was down to count as carried [m]; chosen as
about the radius of an object."""

DOWN = 0.02
"""Height above its lowest up to which the hand still counts as down [m]; chosen: it slides up a tilted bin by less."""

MAX_SLIP = 0.3
"""Largest speed of a carried object relative to the tool [m/s]; chosen. A falling object passes it within 30 ms."""

MIN_TIME = 0.1
"""Shortest time in the hand that counts [s]; chosen: a ball that flies past the hand is not carried."""

MAX_GAP = 0.3
"""Longest interruption after which an object counts as carried throughout [s]; chosen: objects settle in the hand."""

MAX_SHIFT = 0.03
"""Largest displacement in the hand during such an interruption [m]; chosen as about the radius of an object."""

RELEASES = ("release", "drop_back")
"""Names of the primitives that open the hand; what leaves it then is released, not lost."""

ENDINGS = ("kept", "released", "lost")
"""Ways in which the time of an object in the hand ends."""


@dataclass(frozen=True, slots=True)
class Carried:
    """The time of one object in the hand.

    Attributes:
        object: Name of the object.
        start: Time from which on it was carried [s].
        end: Time until which it was carried [s].
        ending: "kept" if it was in the hand in the last frame, "released" if the hand opened, otherwise "lost".
    """

    object: str
    start: float
    end: float
    ending: str


def carried(
    time: Array,
    tool: Array,
    objects: Array,
    names: Sequence[str],
    starts: Sequence[float] = (),
    releases: Sequence[tuple[float, float]] = (),
) -> tuple[Carried, ...]:
    """Return the times of objects in the hand, in the order of their starts.

    An object is carried while it is near the tool, moves with it, and both have risen by `RISE` since the
    hand was down.

    Args:
        time: (F,) times of the frames, strictly increasing [s].
        tool: (F, 3) positions of the tool [m].
        objects: (F, n, 3) positions of the objects [m].
        names: n names of the objects.
        starts: Times at which the attempts of an order begin [s]; none for a single attempt.
        releases: Start and end of each time in which the hand was opened [s].
    """
    if time.size < 2 or not names:
        return ()
    relative = objects - tool[:, None]
    slip = np.linalg.norm(np.diff(relative, axis=0) / np.diff(time)[:, None, None], axis=2)
    slip = np.concatenate([slip[:1], slip])
    inside = (np.linalg.norm(relative, axis=2) < HELD_DISTANCE) & (slip < MAX_SLIP)
    for first, end in _windows(time, starts):
        rows = slice(first, end)
        down = first + _last_down(tool[rows, 2])
        lifted = tool[rows, 2] > tool[down, 2] + RISE
        risen = objects[rows, :, 2] > objects[down, :, 2] + RISE
        inside[rows] &= lifted[:, None] & risen
    opened = _Opened(releases)
    found = [
        Carried(name, float(time[a]), float(time[b]), _ending(float(time[b]), float(time[-1]), opened))
        for column, name in enumerate(names)
        for a, b in _runs(inside[:, column], time, relative[:, column])
    ]
    return tuple(sorted(found, key=lambda one: (one.start, one.object)))


def _windows(time: Array, starts: Sequence[float]) -> list[tuple[int, int]]:
    """Return first frame and end of each attempt."""
    firsts = [0, *(int(k) for k in np.searchsorted(time, sorted(starts)[1:]))]
    return [(a, b) for a, b in zip(firsts, [*firsts[1:], time.size], strict=True) if b > a]


def _last_down(height: Array) -> NDArray[np.intp]:
    """Return for each frame (F,) the last one up to it in which the hand was within `DOWN` of its lowest so far."""
    frames = np.arange(height.size)
    return np.maximum.accumulate(np.where(height <= np.minimum.accumulate(height) + DOWN, frames, 0))


def _runs(flags: NDArray[np.bool_], time: Array, relative: Array) -> list[tuple[int, int]]:
    """Return first and last index of each run of true values that is long enough, across short gaps."""
    runs: list[tuple[int, int]] = []
    for index in np.flatnonzero(flags).tolist():
        last = runs[-1][1] if runs else -1
        short = runs and time[index] - time[last] <= MAX_GAP
        if runs and (index == last + 1 or (short and norm(relative[index] - relative[last]) < MAX_SHIFT)):
            runs[-1] = (runs[-1][0], index)
        else:
            runs.append((index, index))
    return [(a, b) for a, b in runs if time[b] - time[a] >= MIN_TIME]


class _Opened:
    """The times in which the hand was opened, made so that a recording with many of them takes linear time."""

    def __init__(self, releases: Sequence[tuple[float, float]]) -> None:
        # The last frame before an object slips out may lie just before the hand is told to open.
        spans = sorted((start - MIN_TIME, end + MIN_TIME) for start, end in releases)
        self._starts = [start for start, _ in spans]
        self._ends = list(accumulate((end for _, end in spans), max))

    def covers(self, time: float) -> bool:
        """Return whether a span that has begun by `time` lasts until then."""
        begun = bisect_right(self._starts, time)
        return begun > 0 and time <= self._ends[begun - 1]


def _ending(end: float, last: float, opened: _Opened) -> str:
    if end > last - MIN_TIME:
        return "kept"
    return "released" if opened.covers(end) else "lost"


def releases_in(outcomes: Any) -> list[tuple[float, float]]:
    """Return start and end of each recorded primitive that opened the hand [s]."""
    found = []
    for row in outcomes if isinstance(outcomes, list | tuple) else ():
        start, end = number(lookup(row, "start")), number(lookup(row, "end"))
        if lookup(row, "name") in RELEASES and start is not None and end is not None:
            found.append((start, end))
    return found


def attempt_starts(meta: Mapping[str, Any]) -> list[float]:
    """Return the times at which the attempts of an order began [s]; nothing for a single attempt."""
    attempts = meta.get("attempts")
    times = [number(lookup(row, "start")) for row in attempts] if isinstance(attempts, list) else []
    return [time for time in times if time is not None]


def shows_hand(recording: Recording) -> bool:
    """Return whether a recording tells what the hand carried: it has objects and the tool's positions."""
    return any(body.role == "object" for body in recording.bodies) and "tool_position" in recording.signals


def carried_in(recording: Recording) -> tuple[Carried, ...]:
    """Return the times of objects in the hand of a recorded attempt; nothing if the tool was not recorded."""
    chosen = [index for index, body in enumerate(recording.bodies) if body.role == "object"]
    tool = signal_at(recording, "tool_position", recording.frame_time)
    if tool is None or not chosen:
        return ()
    return carried(
        recording.frame_time,
        tool,
        recording.body_position[:, chosen].astype(float),
        [text(recording.bodies[index].name, 40) for index in chosen],
        attempt_starts(recording.meta),
        releases_in(recording.meta.get("outcomes")),
    )


def count_carried(found: Sequence[Carried]) -> dict[str, Any]:
    """Return JSON values of what the hand carried.

    Keys:
        taken: Number of times that an object came into the hand.
        kept: Number of them that were in the hand at the end.
        released: Number of them that left the hand when it opened.
        lost: Number of them that left a closed hand.
        losses: {object, time} of each loss, in order.
    """
    counts = {ending: sum(one.ending == ending for one in found) for ending in ENDINGS}
    losses = [{"object": one.object, "time": one.end} for one in found if one.ending == "lost"]
    return {"taken": len(found), **counts, "losses": sorted(losses, key=lambda loss: loss["time"])}


def emptied(recording: Recording, found: Sequence[Carried], spans: Sequence[tuple[float, float]]) -> list[float | None]:
    """Return for each attempt that held nothing the time from which on it is clear that the hand holds nothing.

    It is the time of the last loss. Without a loss it is the time at which the last primitive that lifts the hand has
    lifted it by `RISE`; None if there is no such primitive.

    Args:
        recording: Recording.
        found: Times of objects in the hand.
        spans: Start and end of each attempt [s].
    """
    losses = sorted(one.end for one in found if one.ending == "lost")
    lifts = sorted(_lifts(recording)) if spans else []
    moments: list[float | None] = []
    for start, end in spans:
        lost = bisect_right(losses, end)
        if lost and losses[lost - 1] >= start:
            moments.append(losses[lost - 1])
            continue
        last = bisect_right(lifts, (end + MIN_TIME, float("inf"), 0.0))
        inside = (lift for lift in reversed(lifts[:last]) if lift[0] >= start - MIN_TIME)
        moments.append(next((risen for _, ended, risen in inside if ended <= end + MIN_TIME), None))
    return moments


def _lifts(recording: Recording) -> list[tuple[float, float, float]]:
    """Return start and end of each primitive that lifts the hand, and when it has lifted it by `RISE` [s]."""
    time, outcomes = recording.frame_time, recording.meta.get("outcomes")
    tool = signal_at(recording, "tool_position", time)
    found: list[tuple[float, float, float]] = []
    if tool is None:
        return found
    for row in outcomes if isinstance(outcomes, list) else []:
        first, last = number(lookup(row, "start")), number(lookup(row, "end"))
        if first is None or last is None or first > last:
            continue
        frames = slice(int(np.searchsorted(time, first)), int(np.searchsorted(time, last, "right")))
        height = tool[frames, 2]
        if height.size and height[-1] > height[0] + 2.0 * RISE:
            found.append((first, last, float(time[frames][np.argmax(height > height[0] + RISE)])))
    return found
