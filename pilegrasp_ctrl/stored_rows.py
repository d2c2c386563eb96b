"""Rows of a study's file and their digests, so that a row is believed only if it is as it was written.

A study keeps the digests of its rows in the table `digests`. A study that was made before has no such table; its rows
are read as they are.
"""

from __future__ import annotations

import hashlib
import json
import re
import shlex
import sqlite3
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from .exceptions import ExportError

DIGESTS = "digests"
"""Table of the digests of the other tables' rows."""

COLUMNS = {
    "about": ("key", "value"),
    "origins": ("name", "identity"),
    "scenarios": ("number", "config_hash", "scenario"),
    "attempts": ("config_hash", "seed", "condition", "result", "error"),
    "costs": ("config_hash", "seed", "processor_time", "wall_time", "host"),
}
"""Columns of each table."""

WITHOUT_DIGEST = ("origins",)
"""Tables whose rows need no digest. Before anything is added to a study, each row is compared with the present one, and
an error names the first difference."""

KEYS = {"about": 1, "origins": 1, "scenarios": 2, "attempts": 2, "costs": 2}
"""Number of leading columns that name a row."""

READ_ERRORS = (sqlite3.Error, UnicodeError)
"""Errors of Python's reader of SQLite files; the second comes from a message about a damaged name."""

REMEDY = "take the file from a copy, or choose another folder"
"""What to do about a damaged file."""


def reason_of(error: Exception) -> str:
    """Return the reason of one of the `READ_ERRORS` in one line."""
    return "a name is not Unicode" if isinstance(error, UnicodeError) else " ".join(str(error).split())


def row_digest(table: str, row: Sequence[Any]) -> str:
    """Return the digest of a row: of its table's name and of its values and their types."""
    values = [value.hex() if isinstance(value, bytes) else value for value in row]
    return hashlib.sha256(json.dumps([table, *values]).encode()).hexdigest()[:32]


def open_for_reading(connection: sqlite3.Connection) -> None:
    """Let texts that are not Unicode through, so that their row can be named."""
    connection.text_factory = lambda content: content.decode("utf-8", errors="surrogateescape")


def check_pages(connection: sqlite3.Connection, file: Path) -> None:
    """Check the pages of the file; a damaged one may hide rows.

    Raises:
        ExportError: A page is damaged.
        sqlite3.Error, UnicodeError: A page is damaged so much that SQLite cannot check it.
    """
    verdict = connection.execute("PRAGMA integrity_check(1)").fetchone()
    if verdict != ("ok",):
        found = " ".join(str(verdict[0] if verdict else "").split())
        raise ExportError(f"{file}: is damaged: {found}; {REMEDY}")


def tables_of(connection: sqlite3.Connection) -> set[str]:
    """Return the names of the tables. In a damaged list of tables SQLite takes a blob for the text that it was."""
    found = connection.execute("SELECT CAST(name AS TEXT) FROM sqlite_master WHERE CAST(type AS TEXT) = 'table'")
    return {name for (name,) in found}


def read_rows(connection: sqlite3.Connection, file: Path, table: str, known: set[str] | None) -> list[tuple[Any, ...]]:
    """Return the rows of a table, each checked.

    Args:
        connection: Open file.
        file: Its path, for the error.
        table: Name of the table, one of `COLUMNS`.
        known: Digests of `digests_in`.

    Raises:
        ExportError: A row is not as it was written.
        sqlite3.Error, UnicodeError: The table cannot be read.
    """
    rows = connection.execute(f"SELECT {', '.join(COLUMNS[table])} FROM {table}").fetchall()
    if known is not None and table not in WITHOUT_DIGEST:
        for row in rows:
            if row_digest(table, row) not in known:
                raise damaged_row(file, table, row)
    return rows


def digests_in(connection: sqlite3.Connection) -> set[str] | None:
    """Return the digests of the rows; None if the study was made before rows had digests."""
    if DIGESTS not in tables_of(connection):
        return None
    return {digest for (digest,) in connection.execute(f"SELECT digest FROM {DIGESTS}")}


def write_digests(connection: sqlite3.Connection, table: str, rows: Iterable[Sequence[Any]]) -> None:
    """Keep the digests of rows that are written in the same transaction, in the types that SQLite returns."""
    digests = ((row_digest(table, row),) for row in rows)
    connection.executemany(f"INSERT OR IGNORE INTO {DIGESTS} VALUES (?)", digests)


def damaged_row(file: Path, table: str, row: Sequence[Any]) -> ExportError:
    """Return the error about a row that is not as it was written."""
    return ExportError(f"{file}: {_name(table, row)} is damaged; {_remedy(file, table, row)}")


def _name(table: str, row: Sequence[Any]) -> str:
    key = list(zip(COLUMNS[table], row, strict=False))[: KEYS[table]]
    named = ", ".join(f"{column} {_shown(value)}" for column, value in key)
    return f"the row of {table} with {named}"


def _remedy(file: Path, table: str, row: Sequence[Any]) -> str:
    key = row[: KEYS[table]]
    # The command is for a shell, and the row may be a stranger's.
    plain = table == "attempts" and re.fullmatch(r"[0-9a-f]{1,64}", str(key[0])) and isinstance(key[1], int)
    if not plain:
        return REMEDY
    query = f"DELETE FROM attempts WHERE config_hash = '{key[0]}' AND seed = {key[1]}"
    return f'run `sqlite3 {shlex.quote(str(file))} "{query}"` and the study\'s command again, or {REMEDY}'


def _shown(value: Any) -> str:
    """Return a value in one line."""
    text = value if isinstance(value, str) else repr(value)
    return repr("".join(letter if letter.isprintable() else "?" for letter in text[:60]))
