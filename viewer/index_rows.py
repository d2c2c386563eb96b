"""The attempts of a study, read from its database without trust in its content."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pilegrasp_ctrl.analysis.reading import lookup, number, plain, text
from pilegrasp_ctrl.exceptions import ExportError
from pilegrasp_ctrl.files import STUDY_FILE


@dataclass(frozen=True, slots=True)
class IndexRow:
    """One attempt of a study.

    Attributes:
        config_hash: Hash of the scenario.
        seed: Seed of pile and noise.
        condition: Label and value of each key that differs between conditions.
        success: Whether the attempt succeeded; None if it raised an error or its result cannot be read.
        grasped: Number of objects held.
        triggered: Whether the push ended by F_grasp.
        words: Reason of the end, or the error.
        duration: Simulated time [s], if known.
    """

    config_hash: str
    seed: int
    condition: tuple[tuple[str, str], ...]
    success: bool | None
    grasped: int
    triggered: bool
    words: str
    duration: float | None

    @property
    def stem(self) -> str:
        """Return the name of the attempt's recording and page, without a suffix."""
        return f"{self.config_hash}-{self.seed}"


def read_attempts(folder: Path) -> list[IndexRow]:
    """Return the attempts of `folder/study.db`, in the order of the database.

    Raises:
        ExportError: The file does not exist, is not a study, or is damaged.
    """
    file = folder / STUDY_FILE
    if not file.is_file():
        raise ExportError(f"{file}: no such study; `pilegrasp sweep ... --out {folder}` makes one")
    try:
        rows = _query(file, "SELECT config_hash, seed, condition, result, error FROM attempts")
    except sqlite3.Error as error:
        raise ExportError(f"{file}: is no study or is damaged: {error}; make it again with `pilegrasp sweep`") from None
    return [_row(*values) for values in rows]


def read_scenario(folder: Path, config_hash: str) -> Mapping[str, Any]:
    """Return the complete scenario of a condition, as the study keeps it.

    Raises:
        ExportError: The study keeps no scenario of this condition.
    """
    file = folder / STUDY_FILE
    try:
        found = _query(file, "SELECT scenario FROM scenarios WHERE config_hash = ?", config_hash)
    except sqlite3.Error:
        found = []
    scenario = _parsed(found[0][0]) if found else None
    if not isinstance(scenario, dict):
        raise ExportError(
            f"{file}: keeps no scenario for {config_hash}, so its attempts cannot be repeated; leave out --recordings"
        )
    return scenario


def _query(file: Path, query: str, *values: str) -> list[tuple[Any, ...]]:
    """Return the rows of a query; the connection is read-only, so that even an old journal changes nothing."""
    connection = sqlite3.connect(f"{file.resolve().as_uri()}?mode=ro", uri=True)
    try:
        return connection.execute(query, values).fetchall()
    finally:
        connection.close()


def _parsed(content: Any) -> Any:
    try:
        return json.loads(content) if isinstance(content, str) else None
    except ValueError:
        return None


def _row(config_hash: Any, seed: Any, condition: Any, result: Any, error: Any) -> IndexRow:
    varied = _parsed(condition)
    varied = varied if isinstance(varied, dict) else {"condition": text(condition, 80)}
    found = _parsed(result)
    success = lookup(found, "success")
    success = success if isinstance(success, bool) and error is None else None
    outcomes = lookup(found, "outcomes")
    outcomes = outcomes if isinstance(outcomes, list) else []
    last = outcomes[-1] if outcomes else None
    if error is not None:
        words = text(error)
    elif success is None:
        words = "the result cannot be read"
    else:
        ended = plain(text(lookup(last, "trigger"), 120))
        words = text(lookup(found, "reason")) or (f"{text(lookup(last, 'name'), 40)}: {ended}" if ended else "")
    safe = "".join(letter for letter in text(config_hash, 80) if letter.isalnum() or letter in "_-")
    return IndexRow(
        config_hash=safe,
        seed=seed if isinstance(seed, int) else 0,
        condition=tuple((text(key, 60), text(value, 60)) for key, value in varied.items()),
        success=success,
        grasped=int(number(lookup(found, "grasped")) or 0),
        triggered=any(lookup(outcome, "trigger") == "grasp force" for outcome in outcomes),
        words=words,
        duration=number(lookup(found, "sim_time")),
    )
