"""The JSON schema of scenario files, for editors."""

from __future__ import annotations

import json
from typing import Any

DRAFT = "https://json-schema.org/draft/2020-12/schema"
"""Draft of JSON Schema in which the schema is written."""


def scenario_schema() -> dict[str, Any]:
    """Return the schema of a scenario file: every key with its meaning, default and range.

    Rules between two keys are not in it; `load_scenario` and `pilegrasp check` know them.
    """
    from ..config import Scenario

    schema: dict[str, Any] = _without_null(Scenario.model_json_schema())
    about = "A scenario of pilegrasp. Every key has a default; a file holds what differs."
    return {"$schema": DRAFT, **schema, "title": "pilegrasp scenario", "description": about}


def schema_text() -> str:
    """Return the schema as the text of its file, `scenarios/scenario.schema.json`."""
    return json.dumps(scenario_schema(), indent=1, ensure_ascii=False) + "\n"


def _without_null(part: Any) -> Any:
    """Return a schema without `null`, which TOML does not have: a key that is absent is left out."""
    if isinstance(part, list):
        return [_without_null(each) for each in part]
    if not isinstance(part, dict):
        return part
    kept = {key: _without_null(value) for key, value in part.items() if (key, value) != ("default", None)}
    if "anyOf" in kept:
        kinds = [kind for kind in kept["anyOf"] if kind != {"type": "null"}]
        kept |= {"anyOf": kinds}
        if len(kinds) == 1:
            del kept["anyOf"]
            kept = {**kinds[0], **kept}
    return kept
