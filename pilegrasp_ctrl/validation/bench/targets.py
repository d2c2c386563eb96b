"""What the project set out to reach, and whether it did."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .result import LoopRow, Row, Target

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
    ratios = {row.key: row.ratio for row in rows}
    for tick in rows:
        arm, own, what = tick.key.partition(" operational space")
        if tick.table != "tick" or not own or what not in ("", ", compiled"):
            continue
        # Peers' ratios are to the tick that is not compiled.
        gain = (ratios[f"{arm} operational space"] or np.nan) / (tick.ratio or np.nan)
        for peer, relation, bound in PEER_TARGETS:
            ratio = ratios.get(f"{arm} {peer}")
            ratio = None if ratio is None else ratio * gain
            if relation == "<=":
                value = None if ratio is None else 1.0 / ratio
                targets.append(_at_most(f"{arm}{what}: tick over {peer}'s", value, bound))
            else:
                targets.append(_at_least(f"{arm}{what}: {peer}'s tick over the project's", ratio, bound))
        targets.append(_at_most(f"{arm}{what}: p99 over median of the tick, within a block", tick.tail, P99_TARGET))
    for line in loop:
        phase = line.phase.partition(",")[0]
        if phase == "push":
            targets.append(_at_most(f"closed loop over bare physics, {line.phase}", line.ratio, LOOP_TARGET))
        else:
            name = f"real-time factor of an {line.phase}, by processor time"
            targets.append(_at_least(name, line.realtime_factor, REALTIME_TARGET))
    return tuple(targets)


def _at_least(name: str, value: float | None, bound: float) -> Target:
    return Target(name=name, value=value, relation=">=", bound=bound, met=None if value is None else value >= bound)


def _at_most(name: str, value: float | None, bound: float) -> Target:
    return Target(name=name, value=value, relation="<=", bound=bound, met=None if value is None else value <= bound)
