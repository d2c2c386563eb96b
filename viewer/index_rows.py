"""The attempts of a study, read from its database without trusting what stands in it."""

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
class AttemptRow:
    """One attempt of a study.

    Attributes:
        config_hash: Hash of its scenario.
        seed: Seed of pile and noise.
        condition: Label and value of each key that tells its condition from the others.
        success: Whether it succeeded; None if it raised an error or its result cannot be read.
        grasped: Number of objects held.
        triggered: Whether the push ended by F_grasp.
        words: Reason of its end, or the error.
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


def read_attempts(folder: Path) -> list[AttemptRow]:
    """Return the attempts of `folder/study.db`, as they stand there.

    Raises:
        ExportError: There is no such file, it is no study, or it is damaged.
    """
    file = folder / STUDY_FILE
    if not file.is_file():
        raise ExportError(f"{file}: no such study; `pilegrasp sweep ... --out {folder}` makes one")
    try:
        # A reader must not change a study, not even by the journal of a writer that has died.
        connection = sqlite3.connect(f"{file.resolve().as_uri()}?mode=ro", uri=True)
        try:
            query = "SELECT config_hash, seed, condition, result, error FROM attempts"
            return [_row(*values) for values in connection.execute(query)]
        finally:
            connection.close()
    except sqlite3.Error as error:
        raise ExportError(f"{file}: is no study or is damaged: {error}; make it again with `pilegrasp sweep`") from None


def read_scenario(folder: Path, config_hash: str) -> Mapping[str, Any]:
    """Return the complete scenario of a condition, as it was written down.

    Raises:
        ExportError: The study keeps none.
    """
    file = folder / STUDY_FILE
    try:
        connection = sqlite3.connect(f"{file.resolve().as_uri()}?mode=ro", uri=True)
        try:
            found = connection.execute(
                "SELECT scenario FROM scenarios WHERE config_hash = ?", (config_hash,)
            ).fetchone()
        finally:
            connection.close()
    except sqlite3.Error:
        found = None
    scenario = None if found is None else _parsed(found[0])
    if not isinstance(scenario, dict):
        raise ExportError(
            f"{file}: keeps no scenario for {config_hash}, so its attempts cannot be repeated; leave out --recordings"
        )
    return scenario


def _parsed(content: Any) -> Any:
    try:
        return json.loads(content) if isinstance(content, str) else None
    except ValueError:
        return None


def _row(config_hash: Any, seed: Any, condition: Any, result: Any, error: Any) -> AttemptRow:
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
    return AttemptRow(
        config_hash=safe,
        seed=seed if isinstance(seed, int) else 0,
        condition=tuple((text(key, 60), text(value, 60)) for key, value in varied.items()),
        success=success,
        grasped=int(number(lookup(found, "grasped")) or 0),
        triggered=any(lookup(outcome, "trigger") == "grasp force" for outcome in outcomes),
        words=words,
        duration=number(lookup(found, "sim_time")),
    )
