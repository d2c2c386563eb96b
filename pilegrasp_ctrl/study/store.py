"""The store of a study: one SQLite file with the attempts, their scenarios and the origins of their results."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from ..config import Scenario, build_scenario
from ..exceptions import ConfigurationError, ExportError
from ..files import RECORDINGS, STUDY_FILE, make_folder, write_output
from .attempt import AttemptReport, AttemptRow
from .condition import Attempt, Condition
from .origins import compare, difference

FORMAT = "pilegrasp-study 1"
"""Format of the file, noted in the table `about`."""
LOCK_TIMEOUT = 60.0
"""How long a writer waits for a reader that locks the file [s] (chosen)."""

_TABLES = """
CREATE TABLE about (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE origins (name TEXT PRIMARY KEY, identity TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE scenarios (number INTEGER PRIMARY KEY, config_hash TEXT NOT NULL UNIQUE, scenario TEXT NOT NULL);
CREATE TABLE attempts (
    config_hash TEXT NOT NULL,
    seed INTEGER NOT NULL,
    condition TEXT NOT NULL,
    result TEXT,
    error TEXT,
    PRIMARY KEY (config_hash, seed)
) WITHOUT ROWID;
CREATE TABLE costs (
    config_hash TEXT NOT NULL,
    seed INTEGER NOT NULL,
    processor_time REAL NOT NULL,
    wall_time REAL NOT NULL,
    host TEXT NOT NULL,
    PRIMARY KEY (config_hash, seed)
) WITHOUT ROWID;
"""
_ROWS = """
SELECT config_hash, seed, condition, result, error
FROM attempts JOIN scenarios USING (config_hash) ORDER BY number, seed
"""


class StudyStore:
    """A study in a folder: `study.db`, and `recordings/` if any were asked for.

    Only one process writes. A transaction is on the disk before the next attempt is handed out. The rollback journal
    with `synchronous=EXTRA` survives a loss of power and works on network file systems. It leaves one file, which can
    be copied.
    """

    def __init__(self, folder: str | Path, *, create: bool = False) -> None:
        """Open the store of a folder.

        Args:
            folder: Folder of the study.
            create: Whether to make folder and store if they are missing.

        Raises:
            ExportError: The store is missing, is not a store, is damaged, or cannot be written.
        """
        self.folder = Path(folder)
        self.path = self.folder / STUDY_FILE
        if not create and not self.path.is_file():
            raise ExportError(f"{self.path}: no such study; `pilegrasp sweep ... --out {self.folder}` makes one")
        if create:
            make_folder(self.folder)
        with self._explained():
            self._connection = sqlite3.connect(self.path, timeout=LOCK_TIMEOUT, isolation_level=None)
        try:
            self._open(create)
        except BaseException:
            self.close()
            raise

    def _open(self, create: bool) -> None:
        with self._explained():
            self._connection.execute("PRAGMA synchronous=EXTRA")
            known = {name for (name,) in self._connection.execute("SELECT name FROM sqlite_master WHERE type='table'")}
            if not known and create:
                self._make()
            elif "about" not in known or self.about("format") != FORMAT:
                raise ExportError(f"{self.path}: is not a study that this version can read; choose another folder")

    def __enter__(self) -> Self:
        """Return the store."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the file."""
        self.close()

    def close(self) -> None:
        """Close the file."""
        self._connection.close()

    @contextmanager
    def _explained(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.Error as error:
            raise ExportError(f"{self.path}: is not a study, is damaged, or cannot be written: {error}") from None

    @contextmanager
    def _transaction(self) -> Iterator[sqlite3.Connection]:
        with self._explained():
            self._connection.execute("BEGIN IMMEDIATE")
            try:
                yield self._connection
            except BaseException:
                self._connection.execute("ROLLBACK")
                raise
            self._connection.execute("COMMIT")

    def _make(self) -> None:
        with self._transaction() as connection:
            for statement in filter(str.strip, _TABLES.split(";")):
                connection.execute(statement)
            connection.execute("INSERT INTO about VALUES ('format', ?)", (FORMAT,))

    def about(self, key: str) -> str | None:
        """Return the value of a key of the table `about`, or None."""
        row = self._connection.execute("SELECT value FROM about WHERE key = ?", (key,)).fetchone()
        return None if row is None else str(row[0])

    def origins(self) -> dict[str, str]:
        """Return the version or digest of everything that the results depend on, by name."""
        with self._explained():
            return dict(self._connection.execute("SELECT name, identity FROM origins"))

    def adopt(
        self,
        conditions: Iterable[Condition],
        origins: Mapping[str, str],
        configuration: Mapping[str, Any] | None = None,
    ) -> None:
        """Note the conditions and origins of the attempts that are going to run, or refuse them.

        Args:
            conditions: Conditions whose scenarios are kept, so that each attempt can be run again.
            origins: Versions and digests that their results depend on.
            configuration: JSON values that identify the study, or None if any will do.

        Raises:
            ConfigurationError: The study was made with other origins or another configuration.
            ExportError: The file cannot be written.
        """
        remedy = "choose another folder, or go back to the versions and files that made the study"
        compare(self.origins(), origins, str(self.path), remedy)
        asked = None if configuration is None else json.dumps(configuration, sort_keys=True)
        known = self.about("configuration")
        if asked is not None and known is not None and asked != known:
            reason = difference(json.loads(known), json.loads(asked))
            raise ConfigurationError(
                f"{self.path} holds another study: {reason}; choose another folder, or repeat the command that began it"
            )
        scenarios = [(condition.config_hash, condition.placed.model_dump_json()) for condition in conditions]
        with self._transaction() as connection:
            connection.executemany("INSERT OR IGNORE INTO origins VALUES (?, ?)", origins.items())
            connection.executemany("INSERT OR IGNORE INTO scenarios (config_hash, scenario) VALUES (?, ?)", scenarios)
            if asked is not None:
                connection.execute("INSERT OR IGNORE INTO about VALUES ('configuration', ?)", (asked,))

    def missing(self, attempts: Sequence[Attempt]) -> list[Attempt]:
        """Return the attempts without a row, each once, in their order."""
        with self._explained():
            known = set(self._connection.execute("SELECT config_hash, seed FROM attempts"))
        wanted = {(condition.config_hash, seed): (condition, seed) for condition, seed in reversed(attempts)}
        return [wanted[key] for key in reversed(wanted) if key not in known]

    def add(self, reports: Sequence[tuple[Condition, AttemptReport]]) -> None:
        """Write finished attempts; when this returns, they are on the disk. A recording is written before its row.

        Raises:
            ExportError: A file cannot be written.
        """
        rows, costs = [], []
        for condition, report in reports:
            key = (report.config_hash, report.seed)
            if report.recording is not None:
                make_folder(self.folder / RECORDINGS)
                write_output(self.recording_file(*key), report.recording, "recording", durable=True)
            rows.append((*key, json.dumps(condition.as_dict()), report.result, report.error))
            costs.append((*key, report.processor_time, report.wall_time, report.host))
        with self._transaction() as connection:
            connection.executemany("INSERT INTO attempts VALUES (?, ?, ?, ?, ?)", rows)
            connection.executemany("INSERT OR REPLACE INTO costs VALUES (?, ?, ?, ?, ?)", costs)

    def attempts(self, asked: Sequence[Attempt] | None = None) -> list[AttemptRow]:
        """Return the rows of the given attempts that exist, in the order of the attempts.

        Without an argument it returns all rows, sorted by condition, in the order in which the conditions were first
        asked for, and then by seed.

        Raises:
            ExportError: The file cannot be read.
        """
        with self._explained():
            rows = self._connection.execute(_ROWS).fetchall()
        if asked is None:
            return [_row(*row) for row in rows]
        known = {row[:2]: row for row in rows}
        keys = dict.fromkeys((condition.config_hash, seed) for condition, seed in asked)
        return [_row(*known[key]) for key in keys if key in known]

    def costs(self) -> dict[tuple[str, int], tuple[float, float]]:
        """Return processor time and wall time of each attempt [s], by hash and seed."""
        with self._explained():
            rows = self._connection.execute("SELECT config_hash, seed, processor_time, wall_time FROM costs")
            return {row[:2]: row[2:] for row in rows}

    def scenario(self, config_hash: str) -> Scenario:
        """Return the complete scenario of a row; `pilegrasp_ctrl.run` with it and the row's seed repeats the attempt.

        Raises:
            ConfigurationError: No scenario has this hash, or a file that it names has changed.
        """
        scenario = build_scenario(self.scenario_values(config_hash), source=str(self.path))
        if scenario.config_hash() != config_hash:
            raise ConfigurationError(f"{self.path}: a file that the scenario {config_hash} names has changed since")
        return scenario

    def scenario_values(self, config_hash: str) -> dict[str, Any]:
        """Return the scenario of a row as nested keys and values.

        Raises:
            ConfigurationError: No scenario has this hash.
        """
        with self._explained():
            query = "SELECT scenario FROM scenarios WHERE config_hash = ?"
            row = self._connection.execute(query, (config_hash,)).fetchone()
        if row is None:
            raise ConfigurationError(f"{self.path}: no scenario has the hash {config_hash!r}")
        return dict(json.loads(row[0]))

    def recording_file(self, config_hash: str, seed: int) -> Path:
        """Return the path of the recording of an attempt, whether it was made or not."""
        return self.folder / RECORDINGS / f"{config_hash}-{seed}.npz"


def _row(config_hash: str, seed: int, condition: str, result: str | None, error: str | None) -> AttemptRow:
    return AttemptRow(config_hash, seed, json.loads(condition), None if result is None else json.loads(result), error)
