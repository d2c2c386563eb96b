"""Prints the table of keys that docs/scenarios.md holds: `python tests/helpers/scenario_table.py`."""

from typing import Any

from pilegrasp_ctrl.config import Scenario, dotted_keys
from pilegrasp_ctrl.statistics import markdown_table


def table() -> str:
    """Return the keys of a scenario as a Markdown table, from the declarations alone."""
    schema = Scenario.model_json_schema()
    rows = [key_row(schema, key) for key in dotted_keys()]
    return markdown_table(("key", "meaning", "unit", "default", "allowed"), rows)


def key_row(schema: dict[str, Any], key: str) -> list[str]:
    """Return key, meaning, unit, default and allowed values of a key as Markdown."""
    return _row(key, _property(schema, key))


def _property(schema: dict[str, Any], key: str) -> dict[str, Any]:
    place = schema
    for part in key.split("."):
        place = place["properties"][part]
        if "$ref" in place:
            place = schema["$defs"][place["$ref"].rpartition("/")[2]]
    return place


def _row(key: str, field: dict[str, Any]) -> list[str]:
    meaning, _, unit = field["description"].removesuffix("]").partition(" [")
    default = "absent" if field["default"] is None else f"`{_toml(field['default'])}`"
    kinds = [kind for kind in field.get("anyOf", [field]) if kind.get("type") != "null"]
    return [f"`{key}`", meaning, unit or "-", default, " or ".join(map(_allowed, kinds))]


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return f'"{value}"' if isinstance(value, str) else str(value).replace("'", '"')


def _allowed(kind: dict[str, Any]) -> str:
    if "enum" in kind or "const" in kind:
        return ", ".join(f'`"{value}"`' for value in kind.get("enum", [kind.get("const")]))
    if kind["type"] == "array":
        entry = _allowed(kind.get("prefixItems", [kind.get("items")])[0])
        return f"{kind['maxItems']} {entry.replace('number', 'numbers')}" if "maxItems" in kind else f"list of {entry}s"
    if kind["type"] == "boolean":
        return "`true`, `false`"
    if kind["type"] == "string":
        return "text"
    signs = {"minimum": "≥", "exclusiveMinimum": ">", "maximum": "≤", "exclusiveMaximum": "<"}
    bounds = [f"{sign} {kind[name]:g}" for name, sign in signs.items() if name in kind]
    return " ".join(["integer" if kind["type"] == "integer" else "number", ", ".join(bounds)]).strip()


if __name__ == "__main__":
    print(table())
