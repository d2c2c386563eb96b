"""Two results of the benchmark beside each other."""

from __future__ import annotations

from math import hypot, sqrt
from typing import NamedTuple

from .result import BenchResult, LoopRow

BETWEEN_RUNS = 0.05
"""How far ratios of two runs of the same code differ beyond what the blocks of either tell.

Each interpreter has its objects at other places in memory: in six runs of the same code the ratios of the project's own
ticks lay within 2 to 5 % of each other.
"""


class Change(NamedTuple):
    """How one line changed.

    Both sides are first divided by the line that they were measured against in their own run, because absolute times of
    two runs say more about the machine than about the code.

    Attributes:
        key: the line, and the line that it was measured against.
        old: its ratio in the saved result.
        new: its ratio now.
        factor: old / new, above 1 where it became faster.
        noise: by how much two runs of the same code may differ, relative: the spreads of both and `BETWEEN_RUNS`, added
            in quadrature.
    """

    key: str
    old: float
    new: float
    factor: float
    noise: float

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
    """Return the change of every line that both results have, against the same other line."""
    changes = []
    for row in new.rows:
        before = old.row(row.key)
        if before is None or before.against != row.against or not row.against:
            continue
        if before.ratio is not None and row.ratio is not None:
            noise = hypot(before.spread or 0.0, row.spread or 0.0, BETWEEN_RUNS)
            changes.append(
                Change(f"{row.key} / {row.against}", before.ratio, row.ratio, before.ratio / row.ratio, noise)
            )
    for line in new.loop:
        for earlier in old.loop:
            if earlier.phase == line.phase:
                noise = hypot(_of_the_median(earlier), _of_the_median(line), BETWEEN_RUNS)
                key = f"closed loop, {line.phase} / bare physics"
                changes.append(Change(key, earlier.ratio, line.ratio, earlier.ratio / line.ratio, noise))
    return changes


def _of_the_median(row: LoopRow) -> float:
    """Return the relative noise of the median; the chunks themselves differ by what happens in them."""
    return (row.ratio_p90 - row.ratio_p10) / (2.0 * row.ratio * sqrt(row.chunks))
