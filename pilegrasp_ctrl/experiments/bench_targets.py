"""What the project set out to reach, and whether it did."""

from __future__ import annotations

from collections.abc import Sequence

from .bench_result import LoopRow, Row, Target

PEER_TARGETS = (("mink", ">=", 2.5), ("pink", ">=", 2.5), ("naive osqp", ">=", 20.0), ("tsid", "<=", 1.7))
"""Tick of a peer over the project's; for TSID, which is C++, the project's over the peer's."""

P99_TARGET, LOOP_TARGET, REALTIME_TARGET = 3.0, 1.5, 5.0


def judge(rows: Sequence[Row], loop: Sequence[LoopRow]) -> tuple[Target, ...]:
    """Return every target with what was measured.

    Args:
        rows: of ticks and peers; a peer's ratio is to the project's operational-space tick.
        loop: of the closed loop.
    """
    targets: list[Target] = []
    ticks = [row for row in rows if row.table == "tick" and row.key.endswith(" operational space")]
    ratios = {row.key: row.ratio for row in rows}
    for tick in ticks:
        arm = tick.key.partition(" ")[0]
        for peer, relation, bound in PEER_TARGETS:
            ratio = ratios.get(f"{arm} {peer}")
            if relation == "<=":
                targets.append(_at_most(f"{arm}: tick over {peer}'s", None if ratio is None else 1.0 / ratio, bound))
            else:
                targets.append(_at_least(f"{arm}: {peer}'s tick over the project's", ratio, bound))
        targets.append(_at_most(f"{arm}: p99 over median of the tick, within a block", tick.tail, P99_TARGET))
    lines = {line.phase: line for line in loop}
    push, attempt = lines.get("push"), lines.get("attempt")
    targets.append(_at_most("closed loop over bare physics, push", push.ratio if push else None, LOOP_TARGET))
    factor = attempt.realtime_factor if attempt else None
    targets.append(_at_least("real-time factor of an attempt, by processor time", factor, REALTIME_TARGET))
    return tuple(targets)


def _at_least(name: str, value: float | None, bound: float) -> Target:
    return Target(name=name, value=value, relation=">=", bound=bound, met=None if value is None else value >= bound)


def _at_most(name: str, value: float | None, bound: float) -> Target:
    return Target(name=name, value=value, relation="<=", bound=bound, met=None if value is None else value <= bound)
