"""JSON in the rows of a study, which may be damaged in a study that has no digests."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..stored_rows import damaged_row
from .attempt import AttemptRow


def attempt_row(row: Sequence[Any], file: Path) -> AttemptRow:
    """Return a row of the table `attempts`.

    Raises:
        ExportError: The row is not what a study writes.
    """
    config_hash, seed, condition, result, error = row
    document = None if result is None else parsed(result, file, "attempts", row)
    whole = (document is None or _is_result(document)) and (error is None or isinstance(error, str))
    if not whole or (document is None) == (error is None):
        raise damaged_row(file, "attempts", row)
    return AttemptRow(config_hash, seed, parsed(condition, file, "attempts", row), document, error)


def parsed(text: Any, file: Path, table: str, row: Sequence[Any]) -> dict[str, Any]:
    """Return the JSON object that a row holds.

    Raises:
        ExportError: The text is something else.
    """
    try:
        document = json.loads(text)
    except (TypeError, ValueError, RecursionError):
        document = None
    if not isinstance(document, dict):
        raise damaged_row(file, table, row)
    return document


def _is_result(document: dict[str, Any]) -> bool:
    outcomes = document.get("outcomes")
    return (
        isinstance(document.get("success"), bool)
        and isinstance(document.get("grasped"), int)
        and isinstance(outcomes, list)
        and all(isinstance(outcome, dict) and {"name", "trigger"} <= outcome.keys() for outcome in outcomes)
    )
