"""The table of keys of a hand's robot.toml is the declared one."""

import hand_key_table
from places import DOCS


def test_the_documented_keys_of_a_hand_are_the_declared_ones():
    page = (DOCS / "how-to" / "own-hand.md").read_text(encoding="utf-8")
    assert hand_key_table.table() in page, "python tests/helpers/hand_key_table.py prints it anew"
