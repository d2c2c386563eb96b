"""The judgement of a benchmark result, by the project's targets and by an earlier result."""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot, sqrt
from statistics import median
from typing import NamedTuple

from .result import BenchResult, LoopRow, Row, Target

PEER_TARGETS = (("mink", ">=", 6.0), ("pink", ">=", 6.0), ("tsid", "<=", 1.1))
"""Peer, relation and bound: a peer's tick over the project's, or for TSID, which is C++, the project's over TSID's.
Chosen as the project's budget; they are ratios of one run on one machine."""

TASK_TARGET = 4.0
"""mink's tick, and Pink's, over the project's with a user's task in plain Python, at least [-]; chosen."""

ACTIVE_TARGET = 0.5
"""The project's tick with limits active over mink's, at most [-]; chosen."""

PUSH_TARGET = 1.3
"""Closed loop over bare `mj_step` during the push with 18 spheres, at most [-]; chosen."""

ATTEMPT_TARGET = 1.6
"""Closed loop over bare `mj_step` during a whole attempt, at most [-]; chosen."""

REALTIME_TARGET = 7.0
"""Simulated time over processor time of a whole attempt, at least [-]; chosen. Bare stepping alone gives 10."""

BETWEEN_RUNS = 0.05
"""Difference between the ratios of two runs of the same code that the spread over the blocks does not show [-].

The objects of each interpreter lie at other places in memory. In six runs of the same code the ratios of the project's
own ticks lay within 2 to 5 % of each other.
"""


def judge(rows: Sequence[Row], loop: Sequence[LoopRow]) -> tuple[Target, ...]:
    """Return every target with its measured value.

    Args:
        rows: Ticks and peers; a peer's ratio is to the project's operational-space tick.
        loop: Statistics of the closed loop.
    """
    targets: list[Target] = []
    ratios = {row.key: row.ratio for row in rows}
    for tick in rows:
        arm, own, suffix = tick.key.partition(" operational space")
        if tick.table != "tick" or not own or suffix:
            continue
        for peer, relation, bound in PEER_TARGETS:
            ratio = ratios.get(f"{arm} {peer}")
            if relation == "<=":
                value = None if ratio is None else 1.0 / ratio
                targets.append(_at_most(f"{arm}: tick over {peer}'s", value, bound))
            else:
                targets.append(_at_least(f"{arm}: {peer}'s tick over the project's", ratio, bound))
                task = _quotient(rows, f"{arm} {peer}", f"{arm} operational space, Python task")
                name = f"{arm}: {peer}'s tick over the project's with a user's Python task"
                targets.append(_at_least(name, task, TASK_TARGET))
        active = _quotient(rows, f"{arm} operational space, limits active", f"{arm} mink")
        targets.append(_at_most(f"{arm}: tick with limits active over mink's", active, ACTIVE_TARGET))
    for line in loop:
        push = line.phase.partition(",")[0] == "push"
        name = f"closed loop over bare physics, {line.phase}"
        targets.append(_at_most(name, line.ratio, PUSH_TARGET if push else ATTEMPT_TARGET))
        if not push:
            name = f"real-time factor of an {line.phase}, by processor time"
            targets.append(_at_least(name, line.realtime_factor, REALTIME_TARGET))
    return tuple(targets)


def _quotient(rows: Sequence[Row], key: str, other: str) -> float | None:
    """Return the ratio of two lines, the median over the blocks; None if one of them is not there."""
    blocks = {row.key: row.blocks_us for row in rows if row.blocks_us}
    if key not in blocks or other not in blocks:
        return None
    # The two blocks of one round ran under the same load of the machine.
    return median(mine / its for mine, its in zip(blocks[key], blocks[other], strict=True))


def _at_least(name: str, value: float | None, bound: float) -> Target:
    return Target(name=name, value=value, relation=">=", bound=bound, met=None if value is None else value >= bound)


def _at_most(name: str, value: float | None, bound: float) -> Target:
    return Target(name=name, value=value, relation="<=", bound=bound, met=None if value is None else value <= bound)


class Change(NamedTuple):
    """The change of one line since an earlier result.

    Absolute times of two runs say more about the machine than about the code. Both sides are therefore ratios to the
    line that they were measured against in their own run.

    Attributes:
        key: Key of the line, and of the line that it was measured against.
        old: Ratio in the saved result.
        new: Ratio of this run.
        factor: Quotient old / new, above 1 if the line became faster.
        noise: Relative difference that two runs of the same code may show: the spreads of both and `BETWEEN_RUNS`,
            added in quadrature.
    """

    key: str
    old: float
    new: float
    factor: float
    noise: float

    @classmethod
    def of(cls, key: str, old: float, new: float, spreads: tuple[float, float]) -> Change:
        """Return the change of a ratio, given the relative spread of both sides."""
        return cls(key, old, new, old / new, hypot(*spreads, BETWEEN_RUNS))

    @property
    def verdict(self) -> str:
        """Return "faster", "slower" or "within noise"."""
        if abs(self.factor - 1.0) <= self.noise:
            return "within noise"
        return "faster" if self.factor > 1.0 else "slower"

    def as_dict(self) -> dict[str, float | str]:
        """Return plain JSON values."""
        return self._asdict() | {"verdict": self.verdict}


def compare(old: BenchResult, new: BenchResult) -> list[Change]:
    """Return the change of every line that both results measured against the same other line."""
    changes = []
    for row in new.rows:
        before = old.row(row.key)
        if before is None or before.against != row.against or before.ratio is None or row.ratio is None:
            continue
        spreads = before.spread or 0.0, row.spread or 0.0
        changes.append(Change.of(f"{row.key} / {row.against}", before.ratio, row.ratio, spreads))
    earlier = {line.phase: line for line in old.loop}
    for line in new.loop:
        if (past := earlier.get(line.phase)) is not None:
            spreads = _noise_of_median(past), _noise_of_median(line)
            changes.append(Change.of(f"closed loop, {line.phase} / bare physics", past.ratio, line.ratio, spreads))
    return changes


def _noise_of_median(row: LoopRow) -> float:
    """Return the relative noise of the median; the chunks themselves differ by what happens in them."""
    return (row.ratio_p90 - row.ratio_p10) / (2.0 * row.ratio * sqrt(row.chunks))
