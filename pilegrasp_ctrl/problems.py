"""What pydantic finds wrong with a value, in the words of a file of the user."""

from __future__ import annotations


def allowed_values(fault: str, message: str) -> str:
    """Return the allowed values of one of pydantic's problems, by its type and message."""
    if fault == "string_pattern_mismatch":
        return "it must not hold control characters"
    if fault == "string_too_short":
        return "it must not be empty"
    for theirs, ours in _WORDS:
        message = message.replace(theirs, ours)
    return message


_WORDS = (
    ("Input should be", "it must be"),
    ("a valid integer", "an integer"),
    ("a valid number", "a number"),
    ("a valid string", "a text"),
    ("a valid dictionary", "a table"),
    ("a valid tuple", "a list"),
    ("an object", "a table"),
    ("less than or equal to", "at most"),
    ("greater than or equal to", "at least"),
)

LISTS = {
    "line.start": "3 numbers, such as [0.5, 0.0, 0.2]",
    "line.displacement": "3 numbers, such as [0.5, 0.0, 0.2]",
    "support.bin_size": "3 numbers, such as [0.4, 0.3, 0.12]",
    "support.bin_wall_heights": "4 numbers, such as [0.16, 0.08, 0.16, 0.16]",
    "support.bin_thickness": "2 numbers, such as [0.01, 0.01]",
    "support.bin_position": "2 numbers, such as [0.7, 0.0]",
    "pile.frame_position": "2 numbers, such as [0.1, 0.0]",
    "order.crate_size": "3 numbers, such as [0.4, 0.3, 0.12]",
    "order.crate_position": "2 numbers, such as [0.6, 0.4]",
}
"""Entries of the keys that are lists of numbers."""
