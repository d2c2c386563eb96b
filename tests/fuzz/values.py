"""Values, texts and bytes as people, programs and enemies write them."""

from __future__ import annotations

import json
import math
import random
from collections.abc import Callable, Mapping
from typing import Any

from hypothesis import strategies as st

PATHS = (
    "",
    ".",
    "..",
    "/",
    "/dev/zero",
    "/dev/null",
    "/proc/self/mem",
    "missing.toml",
    "a/b/c.toml",
    "x" * 300,
    "é.toml",
)
"""Paths in the place of a file that should be read; nothing is ever written to them."""


MINE = (
    b"def plan(parts):\n    return None\n\n\ndef measure(recording):\n    raise ValueError(recording)\n\n\nNAME = 3\n"
)
"""Module with a plan and a measure that are of no use."""

FUNCTIONS = (
    "mine:plan",
    "mine:measure",
    "mine:NAME",
    "mine:missing",
    "beside:plan",
    "os:getcwd",
    "json:dumps",
    "numpy:array",
    "pilegrasp_ctrl.cli:main",
    "pilegrasp_ctrl.analysis.motion:measure",
    "mine.part:plan",
    "mine",
    ":plan",
    "mine:",
    "a:b:c",
    "x" * 300 + ":plan",
    "\x1b[31m:plan",
)
"""Names of functions, as a scenario or an option may hold them."""


def toml(value: Any) -> str:
    """Return a value as TOML."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return repr(value) if math.isfinite(value) else {"inf": "inf", "-inf": "-inf"}.get(repr(value), "nan")
    if isinstance(value, int):
        return f"{value:#x}" if value > 1 << 64 else str(value)
    if isinstance(value, str):
        return json.dumps(value).replace("\x7f", "\\u007f") if value.isascii() else _quoted(value)
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(toml, value))}]"
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{_quoted(key)} = {toml(part)}' for key, part in value.items())}}}"
    return str(value)  # a date


def toml_table(table: Mapping[str, Any]) -> str:
    """Return a table as the text of a file."""
    plain = {key: value for key, value in table.items() if not isinstance(value, Mapping)}
    lines = [f"{_quoted(key)} = {toml(value)}" for key, value in plain.items()]
    for key, value in table.items():
        if isinstance(value, Mapping):
            lines += [f"[{_quoted(key)}]", *(f"{_quoted(name)} = {toml(part)}" for name, part in value.items())]
    return "\n".join(lines) + "\n"


def _quoted(text: str) -> str:
    escaped = {'"': '\\"', "\\": "\\\\"}
    letters = (escaped.get(c) or (c if c.isprintable() else f"\\U{ord(c):08x}") for c in text)
    return f'"{"".join(letters)}"'


def texts(size: int = 30) -> st.SearchStrategy[str]:
    """Texts that a file can hold, some of them paths and some with control characters."""
    letters = st.characters(exclude_categories=("Cs",))
    return st.one_of(
        st.text(letters, max_size=size), st.sampled_from(PATHS), st.sampled_from(("\x1b[31mred", "{}", "%s"))
    )


def numbers() -> st.SearchStrategy[float | int]:
    """Numbers of every size, among them those at which programs break."""
    special = (0, -0.0, 1, -1, 5e-324, 1e-300, 1e300, math.nan, math.inf, -math.inf, 2**31, 2**63, 2**64, 10**400)
    return st.one_of(
        st.sampled_from(special), st.integers(-100, 1000), st.floats(-10.0, 1000.0), st.floats(), st.integers()
    )


def values() -> st.SearchStrategy[Any]:
    """Any value of TOML."""
    leaves = st.one_of(st.booleans(), numbers(), texts(), st.dates())
    return st.one_of(
        leaves,
        st.lists(leaves, max_size=4),
        st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=3),
        st.recursive(leaves, lambda inner: st.lists(inner, max_size=3), max_leaves=8),
        st.dictionaries(texts(8), leaves, max_size=3),
    )


@st.composite
def damaged(draw: Callable[..., Any], content: bytes, most: int = 6) -> bytes:
    """A content with some bytes changed, cut out, put in, or doubled."""
    data = bytearray(content)
    for _ in range(draw(st.integers(1, most))):
        place = draw(st.integers(0, max(0, len(data) - 1)))
        match draw(st.sampled_from(("change", "bit", "cut", "insert", "end", "double"))):
            case "change" if data:
                data[place] = draw(st.integers(0, 255))
            case "bit" if data:
                data[place] ^= 1 << draw(st.integers(0, 7))
            case "cut":
                del data[place : place + draw(st.sampled_from((1, 4, 100)))]
            case "insert":
                data[place:place] = draw(st.binary(min_size=1, max_size=8))
            case "end":
                del data[place:]
            case "double":
                data[place:place] = data[place : place + 200]
    return bytes(data)


def noise(size: int = 4096) -> st.SearchStrategy[bytes]:
    """Bytes without any sense, empty ones among them."""
    return st.one_of(
        st.binary(max_size=64),
        st.builds(
            lambda seed, length: random.Random(seed).randbytes(length), st.integers(0, 1 << 30), st.integers(0, size)
        ),
        st.sampled_from(
            (b"\xff\xfe", b"\xef\xbb\xbf", b"a = " + b"[" * 5000, b"a = " + b"9" * 5000, b"[" * 3000, b"\x00" * 100)
        ),
    )
