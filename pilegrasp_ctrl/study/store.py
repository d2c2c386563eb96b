"""The store of a study: one SQLite file with the attempts, their scenarios and the origins of their results."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from ..config import Scenario, build_scenario
from ..exceptions import ConfigurationError, ExportError
from ..files import RECORDINGS, STUDY_FILE, make_folder, write_output
from ..neutral_values import with_older_meaning
from ..stored_rows import (
    DIGESTS,
    READ_ERRORS,
    check_pages,
    damaged_row,
    digests_in,
    open_for_reading,
    read_rows,
    reason_of,
    tables_of,
    write_digests,
)
from .attempt import AttemptReport, AttemptRow
from .condition import Attempt, Condition
from .origins import compare, difference
from .stored_attempt import attempt_row, parsed

FORMAT = "pilegrasp-study 2"
"""Format of the file, noted in the table `about`: its rows have digests."""
FORMER_FORMAT = "pilegrasp-study 1"
"""Format without digests, which is still read."""
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
CREATE TABLE digests (digest TEXT PRIMARY KEY) WITHOUT ROWID;
"""


class StudyStore:
    """A study in a folder: `study.db`, and `recordings/` if any were asked for.

    Only one process writes. A transaction is on the disk before the next attempt is handed out. The rollback journal
    with `synchronous=EXTRA` survives a loss of power and works on network file systems. It leaves one file, which can
    be copied. Every row has a digest: one that is not as it was written is an error that names it.
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
            open_for_reading(self._connection)
            self._connection.execute("PRAGMA synchronous=EXTRA")
            check_pages(self._connection, self.path)
            known = tables_of(self._connection)
            if not known and create:
                self._make()
            format_ = self.about("format") if "about" in known or not known else None
            self._digests = DIGESTS in tables_of(self._connection)
            if format_ not in (FORMAT, FORMER_FORMAT) or self._digests != (format_ == FORMAT):
                raise ExportError(f"{self.path}: is not a study that this version can read; choose another folder")
        self._read("about")
        self._read_scenarios()

    def _read_scenarios(self) -> None:
        """Keep the rows of the scenarios, by hash: they are few, and asked for one by one."""
        self._scenarios = {row[1]: row for row in self._read("scenarios")}

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
        except READ_ERRORS as error:
            raise ExportError(
                f"{self.path}: is not a study, is damaged, or cannot be written: {reason_of(error)}"
            ) from None

    @contextmanager
    def _transaction(self) -> Iterator[sqlite3.Connection]:
        with self._explained():
            self._connection.execute("BEGIN IMMEDIATE")
            try:
                yield self._connection
            except BaseException:
                with suppress(sqlite3.Error):  # SQLite may have done so itself, as on a full disk
                    self._connection.execute("ROLLBACK")
                raise
            self._connection.execute("COMMIT")

    def _make(self) -> None:
        with self._transaction() as connection:
            for statement in filter(str.strip, _TABLES.split(";")):
                connection.execute(statement)
            connection.execute("INSERT INTO about VALUES ('format', ?)", (FORMAT,))
            write_digests(connection, "about", [("format", FORMAT)])

    def _read(self, table: str) -> list[tuple[Any, ...]]:
        """Return the rows of a table.

        Raises:
            ExportError: A row is damaged, or the file cannot be read.
        """
        with self._explained():
            return read_rows(self._connection, self.path, table, digests_in(self._connection))

    def about(self, key: str) -> str | None:
        """Return the value of a key of the table `about`, or None."""
        value = dict(self._read("about")).get(key)
        return None if value is None else str(value)

    def origins(self) -> dict[str, str]:
        """Return the version or digest of everything that the results depend on, by name."""
        return {str(name): str(identity) for name, identity in self._read("origins")}

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
            reason = difference(parsed(known, self.path, "about", ("configuration",)), json.loads(asked))
            raise ConfigurationError(
                f"{self.path} holds another study: {reason}; choose another folder, or repeat the command that began it"
            )
        scenarios = [(condition.config_hash, condition.placed.model_dump_json()) for condition in conditions]
        with self._transaction() as connection:
            connection.executemany("INSERT OR IGNORE INTO origins VALUES (?, ?)", origins.items())
            connection.executemany("INSERT OR IGNORE INTO scenarios (config_hash, scenario) VALUES (?, ?)", scenarios)
            if asked is not None:
                connection.execute("INSERT OR IGNORE INTO about VALUES ('configuration', ?)", (asked,))
            if self._digests:
                # The rows that were there have been checked when the file was opened.
                for table in ("about", "scenarios"):
                    write_digests(connection, table, read_rows(connection, self.path, table, None))
        self._read_scenarios()

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
            costs.append((*key, float(report.processor_time), float(report.wall_time), report.host))
        with self._transaction() as connection:
            connection.executemany("INSERT INTO attempts VALUES (?, ?, ?, ?, ?)", rows)
            connection.executemany("INSERT OR REPLACE INTO costs VALUES (?, ?, ?, ?, ?)", costs)
            if self._digests:
                write_digests(connection, "attempts", rows)
                write_digests(connection, "costs", costs)

    def attempts(self, asked: Sequence[Attempt] | None = None) -> list[AttemptRow]:
        """Return the rows of the given attempts that exist, in the order of the attempts.

        Without an argument it returns all rows, sorted by condition, in the order in which the conditions were first
        asked for, and then by seed.

        Raises:
            ExportError: The file cannot be read, or a row in it is damaged.
        """
        order = {config_hash: row[0] for config_hash, row in self._scenarios.items()}
        rows = self._read("attempts")
        for row in rows:
            if row[0] not in order or not isinstance(row[1], int):
                raise damaged_row(self.path, "attempts", row)
        if asked is None:
            rows.sort(key=lambda row: (order[row[0]], row[1]))
            return [attempt_row(row, self.path) for row in rows]
        known = {row[:2]: row for row in rows}
        keys = dict.fromkeys((condition.config_hash, seed) for condition, seed in asked)
        return [attempt_row(known[key], self.path) for key in keys if key in known]

    def costs(self) -> dict[tuple[str, int], tuple[float, float]]:
        """Return processor time and wall time of each attempt [s], by hash and seed.

        Raises:
            ExportError: The file cannot be read, or a row in it is damaged.
        """
        rows = self._read("costs")
        for row in rows:
            if not all(isinstance(seconds, int | float) for seconds in row[2:4]):
                raise damaged_row(self.path, "costs", row)
        return {row[:2]: row[2:4] for row in rows}

    def scenario(self, config_hash: str) -> Scenario:
        """Return the complete scenario of a row; `pilegrasp_ctrl.run` with it and the row's seed repeats the attempt.

        Raises:
            ConfigurationError: No scenario has this hash, or a file that it names has changed.
        """
        scenario = build_scenario(with_older_meaning(self.scenario_values(config_hash)), source=str(self.path))
        if scenario.config_hash() != config_hash:
            raise ConfigurationError(f"{self.path}: a file that the scenario {config_hash} names has changed since")
        return scenario

    def scenario_values(self, config_hash: str) -> dict[str, Any]:
        """Return the scenario of a row as nested keys and values.

        Raises:
            ConfigurationError: No scenario has this hash.
            ExportError: The file cannot be read, or the scenario is damaged.
        """
        if config_hash not in self._scenarios:
            raise ConfigurationError(f"{self.path}: no scenario has the hash {config_hash!r}")
        row = self._scenarios[config_hash]
        return parsed(row[2], self.path, "scenarios", row)

    def recording_file(self, config_hash: str, seed: int) -> Path:
        """Return the path of the recording of an attempt, whether it was made or not."""
        return self.folder / RECORDINGS / f"{config_hash}-{seed}.npz"
