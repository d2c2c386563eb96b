"""Writes what follows from a hand's `robot.toml`: its MJCF and the value column of its README.

`python tests/helpers/hand_files.py` (or `make hands`) writes both again for every hand.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from pilegrasp_ctrl.robots import hands, path
from pilegrasp_ctrl.sim.hand import Hand

_ROW = re.compile(r"^\| `([\w.]+)` \| ([^|]*) \|", re.MULTILINE)


def make_mjcf(hand: Hand) -> str:
    """Return the MJCF of sensor and hand on a fixed flange, for any MuJoCo viewer.

    Nothing in it collides: a scene adds the contact pairs that it needs.
    """
    spec = hand.standalone_spec()
    spec.modelname = hand.name
    spec.compile()
    return f"<!-- Made from robot.toml by `make hands`; a change here is lost. -->\n{spec.to_xml().strip()}\n"


def flatten(table: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return the entries of nested tables by their dotted keys, without lists of tables."""
    entries: dict[str, Any] = {}
    for key, value in table.items():
        if isinstance(value, list) and value and isinstance(value[0], dict):
            continue
        entries.update(flatten(value, f"{prefix}{key}.") if isinstance(value, dict) else {f"{prefix}{key}": value})
    return entries


def read_rows(readme: str) -> dict[str, str]:
    """Return the key and the value, as text, of every row of the README's tables of parameters."""
    return dict(_ROW.findall(readme))


def replace_values(readme: str, parameters: dict[str, Any]) -> str:
    """Return the README with the values of `parameters`; a row whose key is not among them stays as it is."""
    texts = {key: _text(value) for key, value in flatten(parameters).items()}
    return _ROW.sub(lambda row: f"| `{row[1]}` | {texts.get(row[1], row[2])} |", readme)


def write(name: str) -> tuple[Path, Path]:
    """Write README and, for a hand with a builder, the MJCF of the hand `name` in its folder; return their paths.

    Raises:
        ModelError: No hand has this name.
    """
    hand = Hand.load(name)
    model, readme = path("hands", name) / f"{name}.xml", path("hands", name, "README.md")
    if hand.description.hand.builder:
        model.write_text(make_mjcf(hand), encoding="utf-8")
    readme.write_text(replace_values(readme.read_text(encoding="utf-8"), hand.parameters), encoding="utf-8")
    return model, readme


def _text(value: Any) -> str:
    if isinstance(value, list):
        return f"({', '.join(map(_text, value))})"
    return f"{value:g}" if isinstance(value, float) else str(value)


if __name__ == "__main__":
    for known in hands():
        for file in write(known.rpartition("/")[2]):
            print(file)
