"""Values that a user types on the command line, as in `--set pile.count=5` and `--vary pile.count=5,10`."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from .exceptions import ConfigurationError
from .files import parse_toml


def parse_value(text: str) -> Any:
    """Return the TOML value of a text; a text that is not a TOML value is a string.

    Raises:
        ConfigurationError: A part of the text would be ignored, or the value has no end.
    """
    if re.search(r"[\x00-\x1f\x7f]", text):
        raise ConfigurationError("a value is one line without control characters")
    try:
        return parse_toml(f"value = {text}\n")["value"] if _is_one_value(text) else text
    except tomllib.TOMLDecodeError:
        return text
    except ValueError as error:
        # Python's sentence about too many digits goes on with advice to programmers.
        raise ConfigurationError(f"this is not a value: {str(error).partition(';')[0]}") from None


def parse_values(text: str) -> list[Any]:
    """Return the TOML values of a text that separates them by commas; a part that is not a TOML value is a string.

    Raises:
        ConfigurationError: A part of the text would be ignored, or a value has no end.
    """
    whole = parse_value(f"[{text}]")
    return whole if isinstance(whole, list) else [parse_value(part.strip()) for part in text.split(",")]


def _is_one_value(text: str) -> bool:
    """Return whether a text is one TOML value, or is none.

    Raises:
        ConfigurationError: The text is a value with a comment behind it, which would be ignored.
    """
    # A comment hides the bracket.
    with suppress(tomllib.TOMLDecodeError):
        return len(parse_toml(f"value = [{text}]\n")["value"]) == 1
    with suppress(tomllib.TOMLDecodeError):
        parse_toml(f"value = {text}\n")
        raise ConfigurationError("what is behind # would be ignored; leave it out")
    return False


def check_text(merged: Mapping[str, Any], source: str) -> None:
    """Refuse text that is not Unicode, such as a file's name in another encoding.

    Raises:
        ConfigurationError: There is such a text.
    """
    try:
        json.dumps(merged, ensure_ascii=False).encode()
    except UnicodeEncodeError as error:
        near = error.object[max(0, error.start - 40) : error.start + 20]
        raise ConfigurationError(
            f"{source}: the name of a file or another text is not Unicode, at {near!r}; rename it"
        ) from None


def to_json(value: Any, source: str) -> str:
    """Return a value as JSON; `source` begins the error of a value that JSON cannot hold."""
    try:
        return json.dumps(value, default=_plain_value)
    except (TypeError, ValueError, RecursionError) as error:
        raise ConfigurationError(f"{source}holds a value that is not a number, text, list or table: {error}") from None


def _plain_value(value: Any) -> Any:
    """Return a path and numpy's numbers and arrays as JSON values."""
    if isinstance(value, Path):
        return str(value)
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"{value} ({type(value).__name__})")
