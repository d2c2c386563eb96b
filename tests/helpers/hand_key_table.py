"""Prints the table of keys of a hand's robot.toml that docs/how-to/own-hand.md holds."""

from typing import Any

from pilegrasp_ctrl.hand_description import HandDescription
from pilegrasp_ctrl.statistics import markdown_table

NEEDED = "needed"
"""Default of a key that every hand must state."""


def table() -> str:
    """Return the keys of a hand's `robot.toml` as a Markdown table, from the declarations alone."""
    schema = HandDescription.model_json_schema()
    rows = []
    for name, place in schema["properties"].items():
        section = schema["$defs"].get(place.get("$ref", "").rpartition("/")[2], {})
        needed = section.get("required", [])
        rows += [_row(f"{name}.{key}", field, key in needed) for key, field in section.get("properties", {}).items()]
    return markdown_table(("key", "meaning", "unit", "default"), rows)


def _row(key: str, field: dict[str, Any], needed: bool) -> list[str]:
    meaning, _, unit = field["description"].removesuffix("]").partition(" [")
    default = NEEDED if needed else "absent" if field.get("default") is None else f"`{_toml(field['default'])}`"
    return [f"`{key}`", meaning, unit or "-", default]


def _toml(value: Any) -> str:
    return f'"{value}"' if isinstance(value, str) else str(value)


if __name__ == "__main__":
    print(table())
