"""The attempts of a study, read from its database without trust in its content."""

from __future__ import annotations

import json
import math
import sqlite3
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pilegrasp_ctrl.analysis.reading import lookup, number, plain, text
from pilegrasp_ctrl.exceptions import ExportError
from pilegrasp_ctrl.files import STUDY_FILE
from pilegrasp_ctrl.stored_rows import (
    READ_ERRORS,
    check_pages,
    digests_in,
    open_for_reading,
    read_rows,
    reason_of,
    tables_of,
)
from pilegrasp_ctrl.viewer.study.picks import Pick, picks_of


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
        implied: Label and value of each further key in which other conditions differ, as the complete scenario says.
        lost: Number of objects that the hand lost, if known.
        picks: Attempts of an order; none for another program.
    """

    config_hash: str
    seed: int
    condition: tuple[tuple[str, str], ...]
    success: bool | None
    grasped: int
    triggered: bool
    words: str
    duration: float | None
    implied: tuple[tuple[str, str], ...] = ()
    lost: int | None = None
    picks: tuple[Pick, ...] = ()

    @property
    def values(self) -> dict[str, str]:
        """Return label and value of each known key."""
        return dict((*self.implied, *self.condition))

    @property
    def stem(self) -> str:
        """Return the name of the attempt's recording and page, without a suffix."""
        return f"{self.config_hash}-{self.seed}"


def read_attempts(folder: Path) -> list[IndexRow]:
    """Return the attempts of `folder/study.db`: conditions in the order in which they were asked for, then by seed.

    Raises:
        ExportError: The file does not exist, is not a study, or is damaged.
    """
    file = folder / STUDY_FILE
    if not file.is_file():
        raise ExportError(f"{file}: no such study; `pilegrasp sweep ... --out {folder}` makes one")
    try:
        scenarios, rows = _read(file, "scenarios", "attempts")
    except READ_ERRORS as error:
        raise ExportError(
            f"{file}: is no study or is damaged: {reason_of(error)}; make it again with `pilegrasp sweep`"
        ) from None
    if scenarios:
        order = {row[1]: row[0] for row in scenarios if isinstance(row[0], int)}
        rows.sort(key=lambda row: (order.get(row[0], math.inf), row[1] if isinstance(row[1], int) else 0))
    return _completed([_row(*values) for values in rows], {row[1]: _parsed(row[2]) for row in scenarios})


def _completed(rows: list[IndexRow], scenarios: Mapping[Any, Any]) -> list[IndexRow]:
    """Return the rows with the values that their conditions leave out and other conditions of the study name."""
    labels = dict.fromkeys(label for row in rows for label, _ in row.condition)
    implied: dict[str, tuple[tuple[str, str], ...]] = {}
    for row in rows:
        if row.config_hash not in implied:
            found = ((label, lookup(scenarios.get(row.config_hash), label)) for label in labels)
            implied[row.config_hash] = tuple(
                (label, text(value, 60)) for label, value in found if isinstance(value, str | int | float)
            )
    return [replace(row, implied=implied[row.config_hash]) for row in rows]


def read_scenario(folder: Path, config_hash: str) -> Mapping[str, Any]:
    """Return the complete scenario of a condition, as the study keeps it.

    Raises:
        ExportError: The study keeps no scenario of this condition, or is damaged.
    """
    file = folder / STUDY_FILE
    try:
        found = [row[2] for row in _read(file, "scenarios")[0] if row[1] == config_hash]
    except READ_ERRORS:
        found = []
    scenario = _parsed(found[0]) if found else None
    if not isinstance(scenario, dict):
        raise ExportError(
            f"{file}: keeps no scenario for {config_hash}, so its attempts cannot be repeated; leave out --recordings"
        )
    return scenario


def _read(file: Path, *tables: str) -> list[list[tuple[Any, ...]]]:
    """Return the rows of tables; the connection is read-only, so that even an old journal changes nothing.

    Rows are checked if the study has digests. A study that is made by hand or old has none, and may lack its scenarios.
    """
    connection = sqlite3.connect(f"{file.resolve().as_uri()}?mode=ro", uri=True)
    try:
        check_pages(connection, file)
        known, present = digests_in(connection), tables_of(connection)
        if known is not None:
            open_for_reading(connection)
        return [
            [] if table == "scenarios" and table not in present else read_rows(connection, file, table, known)
            for table in tables
        ]
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
    elif success and picks_of(found):
        words = "the order is complete"
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
        lost=None if (lost := number(lookup(found, "carried.lost"))) is None else int(lost),
        picks=picks_of(found),
    )
