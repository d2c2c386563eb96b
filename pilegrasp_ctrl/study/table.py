"""A study as one flat table with a line for each attempt, for spreadsheets and pandas."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..exceptions import ExportError
from ..files import write_output
from .attempt import AttemptRow
from .store import StudyStore

TABLES = (".csv", ".parquet")
"""Suffixes of the table files that a study can be written to."""
MAX_COLUMNS = 4096
"""Largest number of columns of a table (chosen). Names that differ from row to row would make cells without end."""
_FIRST = ("scenario", "config_hash", "seed")
_LAST = ("success", "grasped", "triggered", "reason", "error", "processor_time")


def table(store: StudyStore) -> list[dict[str, Any]]:
    """Return a line for each attempt; all lines have the same columns in the same order, None in an empty cell.

    The columns are, in this order:

    - `scenario config_hash seed`,
    - every key that is varied anywhere in the study, with its value in this attempt,
    - `success grasped triggered reason error processor_time`,
    - the rest of the result by dotted names, such as `push.peak_force`; those of a measure begin with `measures.`.

    Raises:
        PilegraspError: The store cannot be read.
    """
    rows, costs = store.attempts(), store.costs()
    varied = list(dict.fromkeys(key for row in rows for key in row.condition if key != "scenario"))
    scenarios = {hash_: store.scenario_values(hash_) for hash_ in dict.fromkeys(row.config_hash for row in rows)}
    lines = []
    for row in rows:
        line: dict[str, Any] = {
            "scenario": row.condition.get("scenario"),
            "config_hash": row.config_hash,
            "seed": row.seed,
        }
        line |= {key: row.condition.get(key, _value(scenarios[row.config_hash], key)) for key in varied}
        result = row.result or {}
        processor_time = costs.get((row.config_hash, row.seed), (None,))[0]
        values = (row.success, row.grasped, row.triggered, result.get("reason"), row.error, processor_time)
        line |= dict(zip(_LAST, values, strict=True))
        lines.append(line | _details(row))
    columns = dict.fromkeys(column for line in lines for column in line)
    if len(columns) > MAX_COLUMNS:
        raise ExportError(
            f"{store.path}: its results have {len(columns)} different names, and a table at most {MAX_COLUMNS} "
            "columns; let a measure return the same names for each attempt"
        )
    return [{column: _cell(line.get(column)) for column in columns} for line in lines]


def write_table(store: StudyStore, path: Path) -> int:
    """Write the table as `.csv` or `.parquet`, by the suffix of the path, and return the number of attempts.

    Raises:
        ExportError: The file cannot be written, or a package for it is not installed.
    """
    if path.suffix == ".parquet":
        require_parquet()
    lines = table(store)
    content = _parquet(lines) if path.suffix == ".parquet" else _csv(lines)
    write_output(path, content, "table")
    return len(lines)


def require_parquet() -> None:
    """Refuse Parquet if it cannot be written.

    Raises:
        ExportError: pyarrow is not installed.
    """
    try:
        import pyarrow.parquet  # noqa: F401
    except ImportError:
        raise ExportError(
            "Parquet needs the package pyarrow; install it with `pip install 'pilegrasp[parquet]'`, or write a .csv"
        ) from None


def _details(row: AttemptRow) -> dict[str, Any]:
    """Return the rest of the result by dotted names; those of a primitive begin with its name."""
    result = dict(row.result or {})
    for name in ("scenario", "config_hash", "seed", "success", "grasped", "reason"):
        result.pop(name, None)
    outcomes = result.pop("outcomes", [])
    found = {
        f"{outcome['name']}.{key}": value for outcome in outcomes for key, value in outcome.items() if key != "name"
    }
    return found | _flat(result)


def _flat(table: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in table.items():
        found |= _flat(value, f"{prefix}{key}.") if isinstance(value, Mapping) else {f"{prefix}{key}": value}
    return found


def _value(scenario: Mapping[str, Any], key: str) -> Any:
    """Return the value of a dotted key of a scenario, or None if it has no such key."""
    place: Any = scenario
    for part in key.split("."):
        place = place.get(part) if isinstance(place, Mapping) else None
    return place


def _cell(value: Any) -> Any:
    return json.dumps(value) if isinstance(value, list | tuple | dict) else value


def _csv(lines: list[dict[str, Any]]) -> bytes:
    text = io.StringIO()
    writer = csv.DictWriter(text, lines[0].keys() if lines else [*_FIRST, *_LAST], lineterminator="\n")
    writer.writeheader()
    writer.writerows(lines)
    return text.getvalue().encode("utf-8", errors="backslashreplace")


def _parquet(lines: list[dict[str, Any]]) -> bytes:
    import pyarrow
    import pyarrow.parquet

    columns = list(lines[0]) if lines else [*_FIRST, *_LAST]
    table = pyarrow.table({column: _array([line[column] for line in lines]) for column in columns})
    buffer = pyarrow.BufferOutputStream()
    pyarrow.parquet.write_table(table, buffer)
    return bytes(buffer.getvalue())


def _array(values: list[Any]) -> Any:
    """Return a column of one type: integers and floats together become floats, any other mixture becomes text."""
    import pyarrow

    types = {type(value) for value in values} - {type(None)}
    if types == {int, float}:
        values = [value if value is None else float(value) for value in values]
    elif len(types) > 1:
        values = [value if value is None else str(value) for value in values]
    return pyarrow.array(values, None if types else pyarrow.string())
