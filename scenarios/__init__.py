"""The scenarios that ship: TOML files that declare an attempt, and short scripts that run as they stand."""

from __future__ import annotations

from difflib import get_close_matches
from pathlib import Path

from pilegrasp_ctrl.exceptions import ConfigurationError

FOLDER = Path(__file__).resolve().parent


def names() -> list[str]:
    """Return the names of the scenarios that ship, in alphabetical order."""
    return sorted(path.stem for path in FOLDER.glob("*.toml"))


def find(name: str | Path) -> Path:
    """Return the TOML file of a scenario.

    Args:
        name: one of `names()`; or the path of a file: a `Path`, or a text that ends in `.toml` or holds a slash.

    Raises:
        ConfigurationError: where no scenario of that name ships.
    """
    if isinstance(name, Path) or name.lower().endswith(".toml") or "/" in name:
        return Path(name)
    if name in names():
        return FOLDER / f"{name}.toml"
    close = get_close_matches(name, names(), n=1)
    remedy = f"did you mean {close[0]!r}?" if close else f"choose from {', '.join(names())}, or give a .toml file"
    raise ConfigurationError(f"no scenario is called {name!r}; {remedy}")
