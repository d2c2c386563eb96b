"""The command that repeats a recorded attempt."""

from __future__ import annotations

import json
import shlex
from collections.abc import Iterator, Mapping
from typing import Any

from pilegrasp_ctrl.analysis.reading import lookup
from pilegrasp_ctrl.config import dotted_keys, load_scenario
from pilegrasp_ctrl.exceptions import PilegraspError
from pilegrasp_ctrl.scenarios import names
from pilegrasp_ctrl.settings import parse_value


def repeat_command(meta: Mapping[str, Any]) -> str:
    """Return the call of `pilegrasp run` that repeats an attempt of a shipped scenario; "" for any other.

    Every value is quoted for a shell, and every key is one of the scenario's, whatever the recording holds.
    """
    name, seed, config = meta.get("scenario"), meta.get("seed"), meta.get("config")
    if name not in names() or not isinstance(seed, int) or not isinstance(config, Mapping):
        return ""
    try:
        changed = dict(_changes(load_scenario(name).model_dump(mode="json"), config))
        if load_scenario(name, changed).model_dump(mode="json") != config:
            return ""
    except PilegraspError:
        return ""
    settings = [word for key, value in changed.items() for word in ("--set", f"{key}={_text(value)}")]
    return shlex.join(["pilegrasp", "run", name, "--seed", str(seed), *settings])


def _changes(shipped: Mapping[str, Any], recorded: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    for key in dotted_keys():
        found = lookup(recorded, key)
        if found != lookup(shipped, key):
            yield key, found


def _text(value: Any) -> str:
    """Return a value as `--set` reads it."""
    if isinstance(value, str):
        try:
            return value if parse_value(value) == value else json.dumps(value)
        except PilegraspError:
            pass
    return json.dumps(value)
