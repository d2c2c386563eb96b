"""The numbers that the paper prints, by name, from their one home `paper_numbers.toml`."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

from pilegrasp_ctrl.files import read_toml

NUMBERS = Path(__file__).with_name("paper_numbers.toml")
"""File of the numbers that the paper prints, with their places."""


@cache
def printed_numbers() -> dict[str, Mapping[str, Any]]:
    """Return every number with its place, in the order of the file."""
    return {row["id"]: row for row in read_toml(NUMBERS)["number"]}


def printed_percent(name: str) -> float:
    """Return a printed share [%]."""
    return 100.0 * float(printed_numbers()[name]["share"])
