"""Where two configurations part, in words."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any


def difference(known: Mapping[str, Any], asked: Mapping[str, Any], prefix: str = "") -> str:
    """Name the first key in which two configurations differ, and both values."""
    for key in [*known, *(key for key in asked if key not in known)]:
        old, new = known.get(key), asked.get(key)
        if old != new:
            if isinstance(old, dict) and isinstance(new, dict):
                return difference(old, new, f"{prefix}{key}.")
            return f"{prefix}{key} = {_shown(old)} there, and {_shown(new)} is asked for"
    return "it was made by another version of this program"


def _shown(value: Any) -> str:
    return "absent" if value is None else f"{json.dumps(value, ensure_ascii=False):.80}"
