"""What a hand can do decides; no code asks for a hand by its name."""

import ast

import pytest

import places
from pilegrasp_ctrl import hand_folder

NAMES = {*hand_folder.names(), "HAND", "SHOVEL"}
FOLDERS = ("pilegrasp_ctrl", "robots", "scenarios", "viewer")


def comparisons(source):
    """Return the lines that compare something with the name of a hand, or match it."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Compare):
            sides = [node.left, *node.comparators]
        elif isinstance(node, ast.MatchValue):
            sides = [node.value]
        else:
            continue
        parts = [part for side in sides for part in ast.walk(side)]
        words = {part.value for part in parts if isinstance(part, ast.Constant) and isinstance(part.value, str)}
        words |= {part.id for part in parts if isinstance(part, ast.Name)}
        if words & NAMES:
            found.append(node.lineno if isinstance(node, ast.Compare) else node.value.lineno)
    return found


def test_no_code_compares_the_name_of_a_hand():
    files = [file for folder in FOLDERS for file in (places.ROOT / folder).rglob("*.py")]
    assert len(files) > 250
    found = {str(file): lines for file in files if (lines := comparisons(file.read_text(encoding="utf-8")))}
    assert found == {}


@pytest.mark.parametrize(
    "source",
    [
        "x = hand == 'shovel'",
        "y = scenario.hand in ('rbo_hand2',)",
        "z = hand != SHOVEL",
        "match h:\n  case 'shovel': 1",
    ],
)
def test_the_search_finds_such_a_comparison(source):
    assert comparisons(source) != []
