"""Errors that a user can cause, each a sentence with cause and remedy, and the remedy for a misspelt name."""

from __future__ import annotations

import re
from collections.abc import Iterable
from difflib import get_close_matches
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

MAX_WORD = 300
"""Longest word of an error text [characters], chosen: above that of a file's name."""

MAX_SENTENCE = 3000
"""Longest error text [characters], chosen: every key of a scenario fits."""


def shortened(text: str) -> str:
    """Return an error text without the middle of its over-long words, and of itself: names may be of any length."""
    text = re.sub(rf"\S{{{MAX_WORD + 1},}}", lambda word: _ends(word[0], MAX_WORD), text)
    return text if len(text) <= MAX_SENTENCE else _ends(text, MAX_SENTENCE)


def _ends(text: str, length: int) -> str:
    """Return the beginning and the end of a text, `length` characters together."""
    half = length // 2
    return f"{text[: half - 1]}…{text[-half:]}"


def remedy_for(name: str, known: Iterable[str], otherwise: str) -> str:
    """Return a question that suggests the nearest of the `known` names, or `otherwise` if none is near."""
    close = get_close_matches(name, known, n=1)
    return f"did you mean {close[0]!r}?" if close else otherwise


def environment_fault(error: BaseException) -> str | None:
    """Return what the environment has refused, if an error comes from that: memory, disk, a missing file or package.

    Such an error says nothing about an attempt, and the attempt may be repeated.
    """
    seen: BaseException | None = error
    while seen is not None:
        if isinstance(seen, EnvironmentRefusal):
            return str(seen)
        if isinstance(seen, OSError | ImportError | MemoryError):
            return shortened(": ".join(filter(None, (type(seen).__name__, " ".join(str(seen).split())))))
        seen = seen.__cause__ or seen.__context__
    return None


class PilegraspError(Exception):
    """Base of every error that the library raises on purpose; its text is one sentence for the user."""

    def __str__(self) -> str:
        return shortened(super().__str__())


class ArgumentError(PilegraspError, ValueError):
    """A Python argument with a wrong shape, a value that is not finite, or a value out of range."""


class GainsError(ArgumentError, TypeError):
    """Gains of the wrong type: `MotionGains` in 1/s² instead of an `Impedance` in N/m, or the reverse."""


class ConfigurationError(PilegraspError):
    """A scenario, key or value that cannot be used."""


class ModelError(PilegraspError):
    """A robot or hand model that is missing or inconsistent."""


class ModelWarning(UserWarning):
    """Something in a model file that the library leaves out."""


class BrakingWarning(UserWarning):
    """A joint that gravity leaves too little torque to brake with, in some postures."""


class UnreachablePoseError(PilegraspError):
    """A pose that the arm cannot take within its limits."""


class PileError(PilegraspError):
    """A pile that cannot be built or does not settle."""


class SolverError(PilegraspError):
    """A quadratic program without a usable solution."""


class PeriodWarning(UserWarning):
    """A controller is called at another rate than the one that it was made for."""


class EnvironmentRefusal(PilegraspError):  # noqa: N818
    """Something that the environment refuses in mid-attempt, such as memory or a file; the attempt has no result."""


class SimulationError(PilegraspError):
    """A simulation that left the range in which it can be believed.

    Attributes:
        reason: Sentence without the name of a file, the same each time.
        file: File with the last states, or None.
    """

    def __init__(self, reason: str, file: Path | None = None) -> None:
        super().__init__(reason)
        self.reason, self.file = reason, file

    def __str__(self) -> str:
        text = super().__str__()
        return text if self.file is None else f"{text} (the last states are in {self.file})"

    def forget_states(self) -> None:
        """Remove the file with the last states."""
        if self.file is not None:
            self.file.unlink(missing_ok=True)
            self.file = None


class RecordingError(PilegraspError):
    """A recording that cannot be read or written."""


class ExportError(PilegraspError):
    """A page or picture that cannot be written."""
