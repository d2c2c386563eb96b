"""How far a study is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class StudyProgress:
    """What is done, and how it went so far.

    Attributes:
        total: attempts that were asked for.
        found: of these, those that a run before this one had finished.
        finished: of these, those that this run has finished.
        successes: among all that are there.
        errors: likewise, attempts that raised.
        seconds: since this run handed out its first attempt [s].
    """

    total: int
    found: int
    finished: int
    successes: int
    errors: int
    seconds: float

    @property
    def done(self) -> int:
        """Attempts that are there."""
        return self.found + self.finished

    @property
    def rate(self) -> float:
        """Attempts a second of this run; 0 before the first."""
        return self.finished / self.seconds if self.seconds > 0.0 else 0.0

    @property
    def seconds_left(self) -> float | None:
        """Time that the rest takes at this rate [s]; None before the first attempt."""
        return (self.total - self.done) / self.rate if self.rate else None


Progress = Callable[[StudyProgress], None]
