"""A synthetic study: the table that a sweep writes, and recordings of some of its attempts."""

from __future__ import annotations

import json
import sqlite3
from pathlib import Path
from typing import Any

from synthetic_recording import outcomes, synthetic

CONDITIONS = {
    "aaaa": {"scenario": "spheres_wall", "pile.count": 5},
    "bbbb": {"scenario": "spheres_wall", "pile.count": 18},
}
SUCCESSES = {"aaaa": 4, "bbbb": 9}
SEEDS = 10

Row = tuple[Any, Any, Any, Any, Any]


def result(config_hash: str, seed: int) -> dict[str, Any]:
    """Return a document like that of `pilegrasp run --json`."""
    success = seed < SUCCESSES[config_hash]
    return {
        "scenario": "spheres_wall",
        "seed": seed,
        "config_hash": config_hash,
        "success": success,
        "grasped": (2 if seed == 0 else 1) if success else 0,
        "reason": "" if success else "push: travel limit of 0.36 m",
        "outcomes": [row | {"trigger": row["trigger"].replace("_", " ")} for row in outcomes(success)],
        "sim_time": 10.0,
    }


def rows() -> list[Row]:
    """Return the rows of two conditions; the last attempt of the first condition raised an error."""
    found: list[Row] = []
    for config_hash, condition in CONDITIONS.items():
        for seed in range(SEEDS):
            raised = config_hash == "aaaa" and seed == SEEDS - 1
            text = None if raised else json.dumps(result(config_hash, seed))
            found.append(
                (config_hash, seed, json.dumps(condition), text, "the pile does not settle" if raised else None)
            )
    return found


def write_study(folder: Path, content: list[Row] | None = None, recorded: tuple[tuple[str, int], ...] = ()) -> Path:
    """Write `study.db`, and short recordings of some attempts; return the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    connection = sqlite3.connect(folder / "study.db")
    with connection:
        connection.execute(
            "CREATE TABLE attempts (config_hash TEXT, seed INTEGER, condition TEXT, result TEXT, error TEXT)"
        )
        connection.executemany("INSERT INTO attempts VALUES (?, ?, ?, ?, ?)", rows() if content is None else content)
    connection.close()
    for config_hash, seed in recorded:
        (folder / "recordings").mkdir(exist_ok=True)
        recording = synthetic(success=seed < SUCCESSES[config_hash], frames=30, objects=8, seed=seed)
        recording.save(folder / "recordings" / f"{config_hash}-{seed}.npz")
    return folder
