"""Straight lines one after the other, at rest in between."""

from __future__ import annotations

from dataclasses import dataclass

from ..types import Reference
from .straight_line import StraightLine


@dataclass(frozen=True, slots=True)
class LineChain:
    """Lines that follow one another; each starts where the one before it ends.

    Attributes:
        lines: at least one.
    """

    lines: tuple[StraightLine, ...]

    @property
    def duration(self) -> float:
        """Time from rest to rest [s]."""
        return sum(line.duration for line in self.lines)

    def at(self, time: float) -> Reference:
        """Return the reference at `time` [s]; at rest at either end outside the motion."""
        for line in self.lines[:-1]:
            if time < line.duration:
                return line.at(time)
            time -= line.duration
        return self.lines[-1].at(time)
