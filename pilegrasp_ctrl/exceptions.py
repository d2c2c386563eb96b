"""Errors that a user can cause, each a sentence with cause and remedy, and the remedy for a misspelt name."""

from collections.abc import Iterable
from difflib import get_close_matches


def remedy_for(name: str, known: Iterable[str], otherwise: str) -> str:
    """Return a question that suggests the nearest of the `known` names, or `otherwise` if none is near."""
    close = get_close_matches(name, known, n=1)
    return f"did you mean {close[0]!r}?" if close else otherwise


class PilegraspError(Exception):
    """Base of every error that the library raises on purpose; its text is one sentence for the user."""


class ArgumentError(PilegraspError, ValueError):
    """A Python argument with a wrong shape, a value that is not finite, or a value out of range."""


class GainsError(ArgumentError, TypeError):
    """Gains of the wrong type: `MotionGains` in 1/s² instead of an `Impedance` in N/m, or the reverse."""


class ConfigurationError(PilegraspError):
    """A scenario, key or value that cannot be used."""


class ModelError(PilegraspError):
    """A robot or hand model that is missing or inconsistent."""


class UnreachablePoseError(PilegraspError):
    """A pose that the arm cannot take within its limits."""


class PileError(PilegraspError):
    """A pile that cannot be built or does not settle."""


class SolverError(PilegraspError):
    """A quadratic program without a usable solution."""


class SimulationError(PilegraspError):
    """A simulation that left the range in which it can be believed."""


class RecordingError(PilegraspError):
    """A recording that cannot be read or written."""


class ExportError(PilegraspError):
    """A page or picture that cannot be written."""
